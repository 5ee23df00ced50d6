// SPDX-License-Identifier: Apache-2.0
#include "gl_context.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <array>

namespace egomod::sim {
namespace {

constexpr const char* kRemedy =
    "rendering needs EGL and OpenGL 3.3 (Debian 12: apt-get install libegl1 libegl-mesa0 "
    "libgl1-mesa-dri)";

}  // namespace

template <typename Function>
Function GlContext::load(const char* name) const {
  auto* const function = reinterpret_cast<Function>(address_of_(name));
  if (function == nullptr) throw GlError(fmt::format("no function {}: {}", name, kRemedy));
  return function;
}

GlContext::GlContext(const char* library) {
  library_ = dlopen(library, RTLD_NOW | RTLD_LOCAL);
  if (library_ == nullptr) throw GlError(fmt::format("{}: {}", dlerror(), kRemedy));
  try {
    address_of_ = reinterpret_cast<PFNEGLGETPROCADDRESSPROC>(dlsym(library_, "eglGetProcAddress"));
    if (address_of_ == nullptr) throw GlError(fmt::format("{}: {}", dlerror(), kRemedy));
    open_display();
    make_context();
#define EGOMOD_GL_LOAD(type, name) gl_.name = load<type>("gl" #name);
    EGOMOD_GL_FUNCTIONS(EGOMOD_GL_LOAD)
#undef EGOMOD_GL_LOAD
  } catch (...) {
    close();
    throw;
  }
}

GlContext::~GlContext() { close(); }

void GlContext::open_display() {
  const auto platform_display = load<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  display_ = platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display_ == EGL_NO_DISPLAY ||
      load<PFNEGLINITIALIZEPROC>("eglInitialize")(display_, nullptr, nullptr) == EGL_FALSE) {
    display_ = EGL_NO_DISPLAY;
    throw GlError(fmt::format("no off-screen display: {}", kRemedy));
  }
}

void GlContext::make_context() {
  const std::array<EGLint, 3> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  const std::array<EGLint, 7> version{EGL_CONTEXT_MAJOR_VERSION,
                                      3,
                                      EGL_CONTEXT_MINOR_VERSION,
                                      3,
                                      EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                      EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  load<PFNEGLBINDAPIPROC>("eglBindAPI")(EGL_OPENGL_API);
  load<PFNEGLCHOOSECONFIGPROC>("eglChooseConfig")(display_, wanted.data(), &config, 1, &count);
  context_ = load<PFNEGLCREATECONTEXTPROC>("eglCreateContext")(
      display_, count > 0 ? config : nullptr, EGL_NO_CONTEXT, version.data());
  if (context_ == EGL_NO_CONTEXT ||
      load<PFNEGLMAKECURRENTPROC>("eglMakeCurrent")(display_, EGL_NO_SURFACE, EGL_NO_SURFACE,
                                                    context_) == EGL_FALSE) {
    throw GlError(fmt::format("no OpenGL 3.3 core context: {}", kRemedy));
  }
}

void GlContext::close() {
  if (display_ != EGL_NO_DISPLAY) {
    load<PFNEGLMAKECURRENTPROC>("eglMakeCurrent")(display_, EGL_NO_SURFACE, EGL_NO_SURFACE,
                                                  EGL_NO_CONTEXT);
    if (context_ != EGL_NO_CONTEXT) {
      load<PFNEGLDESTROYCONTEXTPROC>("eglDestroyContext")(display_, context_);
    }
    load<PFNEGLTERMINATEPROC>("eglTerminate")(display_);
  }
  // The library stays: drivers leave threads and exit handlers behind that need its code.
}

std::string GlContext::renderer() const {
  return reinterpret_cast<const char*>(gl_.GetString(GL_RENDERER));
}

}  // namespace egomod::sim
