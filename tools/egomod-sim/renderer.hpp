// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/image.hpp"
#include "gl_context.hpp"
#include "synthetic_world.hpp"

namespace egomod::sim {

// What a camera sees, pixel by pixel (row-major, at pixel centres).
struct Buffers {
  std::vector<float> depth_m;     // 0 where nothing is hit
  std::vector<std::uint8_t> ids;  // of bodies; 0 for scenery and nothing
};

// Renders a scene through OpenGL: four samples a pixel, trilinear mipmaps. The same scene, time and
// machine give the same bytes. Threads: all calls from the one that made it.
class Renderer {
 public:
  Renderer(const test_support::Scene& scene, const StereoCamera& camera);

  void render(double t_s, const Eigen::Isometry3d& T_camera_world, Image& out);
  // Ids and depth; of one body id alone, or of all with kAll.
  static constexpr int kAll = -1;
  void render_buffers(double t_s, const Eigen::Isometry3d& T_camera_world, int only_id,
                      Buffers& out);
  [[nodiscard]] std::string device() const { return context_.renderer(); }

 private:
  struct Target {
    GLuint framebuffer = 0;
  };
  struct Program {
    GLuint name = 0;
    GLint matrix = -1;
    GLint id = -1;
  };
  [[nodiscard]] Program compile(const char* fragment) const;
  [[nodiscard]] Target target(int samples, const std::vector<GLenum>& colours, bool depth) const;
  void upload_textures();
  void upload_patches();
  void clear_depth() const;
  void draw(const Program& program, double t_s, const Eigen::Isometry3d& T_camera_world,
            int only_id) const;
  void check(const char* what) const;

  GlContext context_;
  const Gl& gl_;
  const test_support::Scene& scene_;
  StereoCamera camera_;
  Program shade_;
  Program identify_;
  Target multisampled_;
  Target resolved_;
  Target buffers_;
  std::vector<GLuint> textures_;
};

}  // namespace egomod::sim
