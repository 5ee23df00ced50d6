// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "renderer.hpp"
#include "scenes.hpp"

namespace egomod::sim {
namespace {

using Eigen::Vector3d;

constexpr double kFeature_px = 0.05;
constexpr double kBorderRow_px = 0.25;  // of one row: there are four samples in a pixel
constexpr double kSide_m = 0.7;
constexpr double kDark = 40.0;
constexpr double kBright = 200.0;
constexpr int kFeatureRows = 12;  // what a corner or a patch takes in

StereoCamera small_camera() {
  return {.fx_px = 262.5,
          .fy_px = 262.5,
          .cx_px = 159.5,
          .cy_px = 119.5,
          .baseline_m = 0.3,
          .width_px = 320,
          .height_px = 240};
}

// A panel that fills the left part of the image up to an edge through (0, 0, depth), which leans by
// so much to the right per metre down: dark left of the edge, bright right of it.
struct LeaningEdge {
  double depth_m;
  double lean;

  [[nodiscard]] double u_px(const StereoCamera& c, int v_px) const {
    const double y_m = (v_px - c.cy_px) / c.fy_px * depth_m;
    return c.cx_px + c.fx_px * lean * y_m / depth_m;
  }
  [[nodiscard]] test_support::Patch parallelogram(double width_m) const {
    return {.corner_m = Vector3d(-lean * kSide_m, -kSide_m, depth_m),
            .edge_s_m = Vector3d(width_m, 0, 0),
            .edge_t_m = Vector3d(2.0 * lean * kSide_m, 2.0 * kSide_m, 0)};
  }
};

void add(test_support::Scene& scene, test_support::Patch patch, const test_support::Paint& paint) {
  patch.texture =
      add_texture(scene, std::abs(patch.edge_s_m.x()), patch.edge_t_m.y(), 0.002, paint);
  scene.bodies.emplace_back().patches.push_back(patch);
}

// The edge is the border of a bright panel before a dark one.
test_support::Scene border(const LeaningEdge& edge) {
  test_support::Scene scene;
  LeaningEdge behind = edge;
  behind.depth_m += 0.5;
  test_support::Patch wall = behind.parallelogram(4.0);
  wall.corner_m.x() -= 2.0;
  wall.corner_m *= 1.5;
  wall.edge_t_m *= 1.5;
  add(scene, wall, [](double, double) { return kDark; });
  add(scene, edge.parallelogram(2.0), [](double, double) { return kBright; });
  return scene;
}

// The edge is painted on a panel.
test_support::Scene painted(const LeaningEdge& edge) {
  test_support::Scene scene;
  test_support::Patch panel = edge.parallelogram(4.0);
  panel.corner_m.x() -= 2.0;
  add(scene, panel, [](double s, double) { return s < 2.0 ? kDark : kBright; });
  return scene;
}

// How far each row's edge lies from where it is due, by the light between two columns around it.
std::vector<double> row_errors(const test_support::Scene& scene, const LeaningEdge& edge) {
  constexpr int kReach_px = 12;
  const StereoCamera camera = small_camera();
  const Renderer renderer(scene, camera);
  const auto canvas = renderer.make_canvas(camera.width_px, camera.height_px);
  const View view{0.0, Eigen::Isometry3d::Identity(), 0, camera.height_px, 0};
  renderer.draw(canvas, pinhole_of(camera), {&view, 1});
  Image image;
  renderer.read(canvas, image);
  std::vector<double> errors;
  for (int v = 60; v < 180; ++v) {
    const double due = edge.u_px(camera, v);
    const int first = static_cast<int>(due) - kReach_px;
    const int end = first + 2 * kReach_px;
    double dark_px = 0.0;
    for (int u = first; u < end; ++u) dark_px += (kBright - image.row(v)[u]) / (kBright - kDark);
    errors.push_back(first - 0.5 + dark_px - due);
  }
  return errors;
}

void expect_edge(const std::function<test_support::Scene(const LeaningEdge&)>& scene,
                 double largest_row_px) {
  for (const LeaningEdge edge : {LeaningEdge{1.7, 0.13}, {2.3, -0.31}, {1.9, 0.02}}) {
    const auto errors = row_errors(scene(edge), edge);
    double sum = 0.0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      EXPECT_LT(std::abs(errors[i]), largest_row_px) << "lean " << edge.lean << " row " << i;
      sum += errors[i];
      if (i % kFeatureRows != kFeatureRows - 1) continue;
      EXPECT_LT(std::abs(sum / kFeatureRows), kFeature_px) << "lean " << edge.lean;
      sum = 0.0;
    }
  }
}

TEST(Edges, PaintedOnesAreWhereGeometryPutsThem) { expect_edge(painted, kFeature_px); }

TEST(Edges, BordersOfSurfacesAreWhereGeometryPutsThem) { expect_edge(border, kBorderRow_px); }

}  // namespace
}  // namespace egomod::sim
