// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/image.hpp"
#include "gl_context.hpp"
#include "synthetic_world.hpp"

namespace egomod::sim {

// Pixel centres on integers.
struct Pinhole {
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  int width_px = 0;
  int height_px = 0;
};
[[nodiscard]] Pinhole pinhole_of(const StereoCamera& camera);

// Some rows of what a pinhole camera sees at one instant; the first of them goes to `canvas_row`.
struct View {
  double t_s = 0.0;
  Eigen::Isometry3d T_camera_world = Eigen::Isometry3d::Identity();
  int first_row = 0;
  int end_row = 0;
  int canvas_row = 0;
};

// Where a body is drawn, and the rows of the view in clip coordinates: low * w <= y <= high * w.
struct Placement {
  Eigen::Matrix4f T_clip_body = Eigen::Matrix4f::Identity();
  float low = -1.0F;
  float high = 1.0F;
};

// Inclusive; empty where the first exceeds the last.
struct PixelBox {
  int first_column = 0;
  int first_row = 0;
  int last_column = 0;
  int last_row = 0;
};

// What a camera sees, pixel by pixel (row-major, at pixel centres).
struct Buffers {
  std::vector<float> depth_m;     // 0 where nothing is hit
  std::vector<std::uint8_t> ids;  // of bodies; 0 for scenery and nothing
};

// Renders a scene through OpenGL: four samples a pixel, trilinear mipmaps, longer filters where
// surfaces are seen flat. The same scene, time and
// machine give the same bytes. Threads: all calls from the one that made it.
class Renderer {
 public:
  // `truth` is the camera of `render_buffers`.
  Renderer(const test_support::Scene& scene, const StereoCamera& truth);

  // What can be drawn on; lives as long as the renderer.
  struct Canvas {
    int width_px = 0;
    int height_px = 0;
    GLuint multisampled = 0;
    GLuint resolved = 0;
  };
  [[nodiscard]] Canvas make_canvas(int width_px, int height_px) const;
  // Only begins to draw: what is drawn on one canvas and read from another overlaps.
  void draw(const Canvas& canvas, const Pinhole& camera, std::span<const View> views) const;
  void read(const Canvas& canvas, Image& out) const;

  void render_buffers(double t_s, const Eigen::Isometry3d& T_camera_world, Buffers& out) const;
  // Pixels that the bodies of this id would show if they were alone.
  [[nodiscard]] int count_alone(double t_s, const Eigen::Isometry3d& T_camera_world, int id);
  [[nodiscard]] std::string device() const { return context_.renderer(); }

 private:
  enum class Surfaces { kAll, kUpright, kSeenFlat };
  struct Program {
    GLuint name = 0;
    GLint matrix = -1;
    GLint id = -1;
    Surfaces surfaces = Surfaces::kAll;  // that it draws
  };
  [[nodiscard]] Program compile(const char* fragment, Surfaces surfaces) const;
  [[nodiscard]] GLuint target(int width_px, int height_px, int samples,
                              const std::vector<GLenum>& colours, bool depth) const;
  void upload_textures();
  void upload_patches();
  void clear_depth() const;
  void draw_body(const Program& program, const test_support::Body& body, GLint first,
                 const Placement& placement) const;
  static constexpr int kAll = -1;
  void draw_view(std::span<const Program> programs, const Pinhole& camera, const View& view,
                 int only_id) const;
  [[nodiscard]] PixelBox box_of(double t_s, const Eigen::Isometry3d& T_camera_world, int id) const;
  void check(const char* what) const;

  GlContext context_;
  const Gl& gl_;
  const test_support::Scene& scene_;
  Pinhole truth_;
  std::array<Program, 2> shade_;
  Program identify_;
  GLuint buffers_ = 0;
  std::vector<std::uint8_t> alone_;
  std::vector<GLuint> textures_;
};

}  // namespace egomod::sim
