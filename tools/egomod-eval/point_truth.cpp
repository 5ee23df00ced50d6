// SPDX-License-Identifier: Apache-2.0
#include "point_truth.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace egomod::eval {
namespace {

// An object reaches as far before the centroid of its visible surface, and behind its centre, as
// these two are apart.
bool at_depth_of(const TruthObject& object, double depth_m) {
  const double reach_m = std::abs(object.centre_m.z() - object.surface_m.z());
  const double slack_m = depth_slack_m(object.surface_m.z());
  return depth_m >= object.surface_m.z() - reach_m - slack_m &&
         depth_m <= object.centre_m.z() + reach_m + slack_m;
}

// By the object that the point's pixel shows; nothing at the edges of objects.
std::optional<bool> moves_by_pixel(const Truth& truth, const PointEvidence& point,
                                   PixelTruth& pixels) {
  const auto owner = pixels.object_at(point);
  if (!owner) return std::nullopt;
  const auto objects = truth.objects->find(point.frame);
  if (*owner == 0 || objects == truth.objects->end()) return false;
  return std::any_of(objects->second.begin(), objects->second.end(),
                     [&](const TruthObject& object) {
                       return object.moving && object.id == std::to_string(*owner);
                     });
}

// By rectangles and depth; nothing where they leave it open.
std::optional<bool> moves_by_rectangle(const Truth& truth, const PointEvidence& point) {
  const auto objects = truth.objects->find(point.frame);
  if (objects == truth.objects->end()) return false;
  bool open = false;
  for (const TruthObject& object : objects->second) {
    if (!object.moving || object.visible_px <= 0 ||
        !object.rectangle.contains(point.u_px, point.v_px)) {
      continue;
    }
    if (at_depth_of(object, point.depth_m)) return true;
    open = true;
  }
  return open ? std::nullopt : std::optional(false);
}

}  // namespace

PointTruth::PointTruth(const Truth& truth)
    : truth_(truth), pixels_(PixelTruth::open(truth.folder)) {}

std::optional<bool> PointTruth::moves(const PointEvidence& point) {
  return pixels_ ? moves_by_pixel(truth_, point, *pixels_) : moves_by_rectangle(truth_, point);
}

}  // namespace egomod::eval
