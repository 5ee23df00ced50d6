// SPDX-License-Identifier: Apache-2.0
#include "renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

namespace egomod::sim {
namespace {

using test_support::Body;
using test_support::Patch;

constexpr int kSamples = 4;
constexpr double kNear_m = 0.1;
constexpr double kFar_m = 2000.0;
constexpr float kSky = 0.82F;
constexpr int kVerticesPerPatch = 6;

constexpr const char* kVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 paint;
uniform mat4 matrix;
out vec2 st;
flat out float light;
void main() {
  gl_Position = matrix * vec4(position, 1.0);
  st = paint.xy;
  light = paint.z;
})";
constexpr const char* kShade = R"(#version 330 core
in vec2 st;
flat in float light;
uniform sampler2D surface;
layout(location = 0) out float grey;
void main() { grey = texture(surface, st).r * light; })";
// The footprint of a pixel on a surface seen flat is long and narrow: four probes along it instead
// of one that blurs it to its length. (The anisotropic filter of llvmpipe takes seconds.)
constexpr const char* kShadeFlat = R"(#version 330 core
in vec2 st;
flat in float light;
uniform sampler2D surface;
layout(location = 0) out float grey;
void main() {
  vec2 size = vec2(textureSize(surface, 0));
  vec2 x = dFdx(st) * size;
  vec2 y = dFdy(st) * size;
  float x2 = dot(x, x);
  float y2 = dot(y, y);
  vec2 along = (x2 > y2 ? x : y) / size;
  float lod = 0.5 * log2(max(max(x2, y2) / 16.0, min(x2, y2)));
  float sum = textureLod(surface, st - 0.375 * along, lod).r;
  sum += textureLod(surface, st - 0.125 * along, lod).r;
  sum += textureLod(surface, st + 0.125 * along, lod).r;
  sum += textureLod(surface, st + 0.375 * along, lod).r;
  grey = 0.25 * sum * light;
})";
// 1 / gl_FragCoord.w is the clip coordinate w, which is the depth.
constexpr const char* kIdentify = R"(#version 330 core
uniform uint id;
layout(location = 0) out uint seen;
layout(location = 1) out float depth;
void main() { seen = id; depth = 1.0 / gl_FragCoord.w; })";

struct Vertex {
  Eigen::Vector3f position;
  Eigen::Vector3f paint;  // s, t, light
};

void append(const Patch& patch, std::vector<Vertex>& out) {
  constexpr std::array<std::pair<double, double>, kVerticesPerPatch> kCorners{
      {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}};
  for (const auto& [s, t] : kCorners) {
    const Eigen::Vector3d P = patch.corner_m + s * patch.edge_s_m + t * patch.edge_t_m;
    out.push_back({P.cast<float>(), Eigen::Vector3d(s, t, patch.brightness).cast<float>()});
  }
}

// Pixel centres on integers here, on halves in OpenGL; image rows go down as the window's go up,
// so that row 0 is read first.
Eigen::Matrix4d projection(const Pinhole& c) {
  Eigen::Matrix4d P = Eigen::Matrix4d::Zero();
  P(0, 0) = 2.0 * c.fx_px / c.width_px;
  P(0, 2) = 2.0 * (c.cx_px + 0.5) / c.width_px - 1.0;
  P(1, 1) = 2.0 * c.fy_px / c.height_px;
  P(1, 2) = 2.0 * (c.cy_px + 0.5) / c.height_px - 1.0;
  P(2, 2) = (kFar_m + kNear_m) / (kFar_m - kNear_m);
  P(2, 3) = -2.0 * kFar_m * kNear_m / (kFar_m - kNear_m);
  P(3, 2) = 1.0;
  return P;
}

Placement rows_of(const Pinhole& camera, const View& view) {
  const auto limit = [&](int row) {
    return static_cast<float>(2.0 * row / camera.height_px - 1.0);
  };
  return {Eigen::Matrix4f::Identity(), limit(view.first_row), limit(view.end_row)};
}

// Whether all corners lie beyond the same border of the view.
bool is_outside(const Patch& patch, const Placement& placement) {
  const Eigen::Vector3f corner = patch.corner_m.cast<float>();
  const Eigen::Vector3f s = patch.edge_s_m.cast<float>();
  const Eigen::Vector3f t = patch.edge_t_m.cast<float>();
  unsigned beyond = 0b11111;
  for (const Eigen::Vector3f& P : {corner, Eigen::Vector3f(corner + s), Eigen::Vector3f(corner + t),
                                   Eigen::Vector3f(corner + s + t)}) {
    const Eigen::Vector4f c = placement.T_clip_body * P.homogeneous();
    const float w = c.w();
    beyond &= (c.x() < -w ? 1U : 0U) | (c.x() > w ? 2U : 0U) |
              (c.y() < placement.low * w ? 4U : 0U) | (c.y() > placement.high * w ? 8U : 0U) |
              (c.z() < -w ? 16U : 0U);
    if (beyond == 0) return false;
  }
  return true;
}

}  // namespace

Pinhole pinhole_of(const StereoCamera& c) {
  return {c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.width_px, c.height_px};
}

Renderer::Renderer(const test_support::Scene& scene, const StereoCamera& truth)
    : gl_(context_.gl()), scene_(scene), truth_(pinhole_of(truth)) {
  shade_ = {compile(kShade, Surfaces::kUpright), compile(kShadeFlat, Surfaces::kSeenFlat)};
  identify_ = compile(kIdentify, Surfaces::kAll);
  buffers_ = target(truth.width_px, truth.height_px, 0, {GL_R8UI, GL_R32F}, true);
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.Enable(GL_DEPTH_TEST);
  upload_textures();
  upload_patches();
  check("setting up");
}

void Renderer::check(const char* what) const {
  const GLenum error = gl_.GetError();
  if (error != GL_NO_ERROR) throw GlError(fmt::format("OpenGL error {:#x} in {}", error, what));
}

Renderer::Program Renderer::compile(const char* fragment, Surfaces surfaces) const {
  const GLuint program = gl_.CreateProgram();
  for (const auto& [kind, source] :
       {std::pair{GL_VERTEX_SHADER, kVertexShader}, std::pair{GL_FRAGMENT_SHADER, fragment}}) {
    const GLuint shader = gl_.CreateShader(static_cast<GLenum>(kind));
    gl_.ShaderSource(shader, 1, &source, nullptr);
    gl_.CompileShader(shader);
    gl_.AttachShader(program, shader);
  }
  gl_.LinkProgram(program);
  GLint linked = GL_FALSE;
  gl_.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE) {
    std::array<char, 1024> log{};
    gl_.GetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw GlError(fmt::format("the driver refuses a shader: {}", log.data()));
  }
  return {program, gl_.GetUniformLocation(program, "matrix"), gl_.GetUniformLocation(program, "id"),
          surfaces};
}

GLuint Renderer::target(int width_px, int height_px, int samples,
                        const std::vector<GLenum>& colours, bool depth) const {
  GLuint framebuffer = 0;
  gl_.GenFramebuffers(1, &framebuffer);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  const auto attach = [&](GLenum format, GLenum point) {
    GLuint buffer = 0;
    gl_.GenRenderbuffers(1, &buffer);
    gl_.BindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl_.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width_px, height_px);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, point, GL_RENDERBUFFER, buffer);
  };
  std::vector<GLenum> points;
  for (const GLenum format : colours) {
    points.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(points.size()));
    attach(format, points.back());
  }
  if (depth) attach(GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
  gl_.DrawBuffers(static_cast<GLsizei>(points.size()), points.data());
  if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw GlError(fmt::format("the driver cannot draw {}x{} pixels with {} samples", width_px,
                              height_px, samples));
  }
  return framebuffer;
}

Renderer::Canvas Renderer::make_canvas(int width_px, int height_px) const {
  return {width_px, height_px, target(width_px, height_px, kSamples, {GL_R8}, true),
          target(width_px, height_px, 0, {GL_R8}, false)};
}

void Renderer::upload_textures() {
  textures_.resize(scene_.textures.size());
  gl_.GenTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
  for (std::size_t i = 0; i < textures_.size(); ++i) {
    const test_support::Texture& texture = scene_.textures[i];
    gl_.BindTexture(GL_TEXTURE_2D, textures_[i]);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, texture.width_texels(), texture.height_texels(), 0,
                   GL_RED, GL_UNSIGNED_BYTE, texture.texels().data());
    gl_.GenerateMipmap(GL_TEXTURE_2D);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
}

void Renderer::upload_patches() {
  std::vector<Vertex> vertices;
  for (const Body& body : scene_.bodies) {
    for (const Patch& patch : body.patches) append(patch, vertices);
  }
  GLuint array = 0;
  GLuint buffer = 0;
  gl_.GenVertexArrays(1, &array);
  gl_.BindVertexArray(array);
  gl_.GenBuffers(1, &buffer);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffer);
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
                 vertices.data(), GL_STATIC_DRAW);
  gl_.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex), nullptr);
  gl_.VertexAttribPointer(
      1, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex),
      // OpenGL takes the offset as a pointer. NOLINTNEXTLINE(performance-no-int-to-ptr)
      reinterpret_cast<const void*>(offsetof(Vertex, paint)));
  gl_.EnableVertexAttribArray(0);
  gl_.EnableVertexAttribArray(1);
}

void Renderer::draw_body(const Program& program, const Body& body, GLint first,
                         const Placement& placement) const {
  gl_.UseProgram(program.name);
  gl_.UniformMatrix4fv(program.matrix, 1, GL_FALSE, placement.T_clip_body.data());
  if (program.id >= 0) gl_.Uniform1ui(program.id, static_cast<GLuint>(body.id));
  for (const Patch& patch : body.patches) {
    const bool is_wanted = program.surfaces == Surfaces::kAll ||
                           patch.is_seen_flat == (program.surfaces == Surfaces::kSeenFlat);
    if (is_wanted && !is_outside(patch, placement)) {
      gl_.BindTexture(GL_TEXTURE_2D, textures_[patch.texture]);
      gl_.DrawArrays(GL_TRIANGLES, first, kVerticesPerPatch);
    }
    first += kVerticesPerPatch;
  }
}

void Renderer::draw_view(std::span<const Program> programs, const Pinhole& camera, const View& view,
                         int only_id) const {
  gl_.Viewport(0, view.canvas_row - view.first_row, camera.width_px, camera.height_px);
  const Eigen::Matrix4d P = projection(camera) * view.T_camera_world.matrix();
  Placement placement = rows_of(camera, view);
  GLint first = 0;
  for (const Body& body : scene_.bodies) {
    if (only_id == kAll || body.id == only_id) {
      placement.T_clip_body = (P * body.T_world_body(view.t_s).matrix()).cast<float>();
      for (const Program& program : programs) draw_body(program, body, first, placement);
    }
    first += static_cast<GLint>(body.patches.size()) * kVerticesPerPatch;
  }
}

void Renderer::clear_depth() const {
  const float farthest = 1.0F;
  gl_.ClearBufferfv(GL_DEPTH, 0, &farthest);
}

void Renderer::draw(const Canvas& canvas, const Pinhole& camera,
                    std::span<const View> views) const {
  const auto [width, height] = std::pair{canvas.width_px, canvas.height_px};
  gl_.BindFramebuffer(GL_FRAMEBUFFER, canvas.multisampled);
  gl_.Disable(GL_SCISSOR_TEST);
  const std::array<float, 4> sky{kSky, 0.0F, 0.0F, 1.0F};
  gl_.ClearBufferfv(GL_COLOR, 0, sky.data());
  clear_depth();
  gl_.Enable(GL_SCISSOR_TEST);
  for (const View& view : views) {
    gl_.Scissor(0, view.canvas_row, camera.width_px, view.end_row - view.first_row);
    draw_view(shade_, camera, view, kAll);
  }
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, canvas.resolved);
  gl_.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl_.Flush();
  check("drawing");
}

void Renderer::read(const Canvas& canvas, Image& out) const {
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, canvas.resolved);
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  out.resize(canvas.width_px, canvas.height_px);
  gl_.PixelStorei(GL_PACK_ROW_LENGTH, static_cast<GLint>(out.stride_bytes()));
  gl_.ReadPixels(0, 0, canvas.width_px, canvas.height_px, GL_RED, GL_UNSIGNED_BYTE, out.row(0));
  gl_.PixelStorei(GL_PACK_ROW_LENGTH, 0);
  check("reading an image");
}

void Renderer::render_buffers(double t_s, const Eigen::Isometry3d& T_camera_world,
                              Buffers& out) const {
  const auto [width, height] = std::pair{truth_.width_px, truth_.height_px};
  gl_.BindFramebuffer(GL_FRAMEBUFFER, buffers_);
  gl_.Disable(GL_SCISSOR_TEST);
  const std::array<GLuint, 4> nothing{};
  const std::array<float, 4> nowhere{};
  gl_.ClearBufferuiv(GL_COLOR, 0, nothing.data());
  gl_.ClearBufferfv(GL_COLOR, 1, nowhere.data());
  clear_depth();
  draw_view({&identify_, 1}, truth_, {t_s, T_camera_world, 0, height, 0}, kAll);
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  out.ids.resize(pixels);
  out.depth_m.resize(pixels);
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_.ReadPixels(0, 0, width, height, GL_RED_INTEGER, GL_UNSIGNED_BYTE, out.ids.data());
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT1);
  gl_.ReadPixels(0, 0, width, height, GL_RED, GL_FLOAT, out.depth_m.data());
  check("rendering ids and depth");
}

// Around the corners of their patches; the whole image where one lies behind the camera.
PixelBox Renderer::box_of(double t_s, const Eigen::Isometry3d& T_camera_world, int id) const {
  const Pinhole& c = truth_;
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  for (const Body& body : scene_.bodies) {
    if (body.id != id) continue;
    const Eigen::Isometry3d T = T_camera_world * body.T_world_body(t_s);
    for (const Patch& patch : body.patches) {
      for (int i = 0; i < 4; ++i) {
        const Eigen::Vector3d P =
            T * (patch.corner_m + (i & 1) * patch.edge_s_m + (i >> 1) * patch.edge_t_m);
        if (P.z() < kNear_m) return {0, 0, c.width_px - 1, c.height_px - 1};
        const Eigen::Array2d pixel(c.fx_px * P.x() / P.z() + c.cx_px,
                                   c.fy_px * P.y() / P.z() + c.cy_px);
        low = low.min(pixel);
        high = high.max(pixel);
      }
    }
  }
  const Eigen::Array2d last(c.width_px - 1, c.height_px - 1);
  const Eigen::Array2i from = low.floor().max(0.0).min(last + 1.0).cast<int>();
  const Eigen::Array2i to = high.ceil().max(-1.0).min(last).cast<int>();
  return {from.x(), from.y(), to.x(), to.y()};
}

int Renderer::count_alone(double t_s, const Eigen::Isometry3d& T_camera_world, int id) {
  const PixelBox box = box_of(t_s, T_camera_world, id);
  const int width = box.last_column - box.first_column + 1;
  const int height = box.last_row - box.first_row + 1;
  if (width <= 0 || height <= 0) return 0;
  gl_.BindFramebuffer(GL_FRAMEBUFFER, buffers_);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(box.first_column, box.first_row, width, height);
  const std::array<GLuint, 4> nothing{};
  gl_.ClearBufferuiv(GL_COLOR, 0, nothing.data());
  clear_depth();
  draw_view({&identify_, 1}, truth_, {t_s, T_camera_world, 0, truth_.height_px, 0}, id);
  gl_.Disable(GL_SCISSOR_TEST);
  alone_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_.ReadPixels(box.first_column, box.first_row, width, height, GL_RED_INTEGER, GL_UNSIGNED_BYTE,
                 alone_.data());
  check("counting pixels");
  return static_cast<int>(std::ranges::count(alone_, static_cast<std::uint8_t>(id)));
}

}  // namespace egomod::sim
