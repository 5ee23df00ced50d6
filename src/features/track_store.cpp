// SPDX-License-Identifier: Apache-2.0
#include "track_store.hpp"

#include <cmath>

namespace egomod {

bool holds_template(const ImageView& image, PixelPosition pixel) {
  return pixel.u_px >= kTemplateMargin_px && pixel.v_px >= kTemplateMargin_px &&
         pixel.u_px < image.width_px - kTemplateMargin_px &&
         pixel.v_px < image.height_px - kTemplateMargin_px;
}

TrackStore::TrackStore(int capacity) : anchors_(static_cast<std::size_t>(capacity)) {
  points_.reserve(anchors_.size());
  free_anchors_.reserve(anchors_.size());
  for (std::int32_t i = capacity - 1; i >= 0; --i) free_anchors_.push_back(i);
}

void TrackStore::anchor_here(const ImageView& left, FollowedPoint& point) {
  const PixelPosition pixel = nearest_pixel(point.left);
  build_template(left, pixel.u_px, pixel.v_px, anchors_[static_cast<std::size_t>(point.anchor)]);
  point.warp = {.u_px = static_cast<float>(pixel.u_px), .v_px = static_cast<float>(pixel.v_px)};
  point.offset = {point.left.u_px - point.warp.u_px, point.left.v_px - point.warp.v_px};
}

FollowedPoint& TrackStore::add(const ImageView& left, PixelPosition pixel, CornerKind kind) {
  FollowedPoint& point = points_.emplace_back();
  point.id = ++last_id_;
  point.anchor = free_anchors_.back();
  free_anchors_.pop_back();
  point.kind = kind;
  point.left = {static_cast<float>(pixel.u_px), static_cast<float>(pixel.v_px)};
  anchor_here(left, point);
  return point;
}

void TrackStore::clear() {
  drop_if([](const FollowedPoint&) { return true; });
}

}  // namespace egomod
