// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "egomod/core/track_set.hpp"
#include "egomod/features/corners.hpp"
#include "egomod/features/image_point.hpp"
#include "egomod/features/patch_alignment.hpp"

namespace egomod {

// Disparity of a left point, and the slopes of the plane d + slope_u x + slope_v y around it.
struct StereoMeasurement {
  bool valid = false;
  float disparity_px = 0.0F;
  float slope_u = 0.0F;
  float slope_v = 0.0F;
  float ncc = 0.0F;
  float variance_px2 = 0.0F;  // of the disparity, from residual and texture
  ImagePoint skew_shift{};    // of the point in the right image, see Skew; zero without skew
  float skew_variance_px2 = 0.0F;
};

// So many, and the right camera is not asked for the point any more.
inline constexpr int kMaxPairsWithoutStereo = 5;

// All that is remembered of one followed point. `warp` takes its anchor template, which sits on a
// whole pixel, to the current left image; the point itself lies `offset` away from that pixel.
struct FollowedPoint {
  std::uint64_t id = 0;
  std::uint32_t age = 0;
  std::int32_t anchor = 0;  // index into TrackStore::anchors
  CornerKind kind = CornerKind::kDark;

  AffineWarp warp;
  ImagePoint offset;
  ImagePoint left;
  ImagePoint flow;  // from the previous to this image
  bool has_flow = false;
  float ncc = 1.0F;
  float usual_ncc = 0.0F;  // its own level, slowly forgotten
  AffineWarp previous_warp;
  ImagePoint previous_left;

  StereoMeasurement stereo;  // the last valid one, `valid` only when of this pair
  StereoMeasurement previous_stereo;
  float disparity_rate_px = 0.0F;      // a pair
  float expected_disparity_px = 0.0F;  // in this pair
  bool rests = true;                   // was seen where it would rest, so far
  ImagePoint own_motion{};             // in the left image, from where it would rest
  int pairs_moving = 0;                // in a row, by a motion of its own
  int pairs_without_stereo = 0;

  bool followed = false;  // found in this pair's left image
  bool reanchored = false;
  bool refuted = false;  // its match is another point's
  bool has_previous_observation = false;
  StereoObservation observation;
  StereoObservation previous_observation;
};

// The right camera has lost it for good: it bears nothing else out.
[[nodiscard]] inline bool is_left_only(const FollowedPoint& point) {
  return point.pairs_without_stereo > kMaxPairsWithoutStereo;
}

[[nodiscard]] inline ImagePoint point_of(const AffineWarp& warp, ImagePoint offset) {
  return {warp.u_px + warp.a * offset.u_px + warp.b * offset.v_px,
          warp.v_px + warp.c * offset.u_px + warp.d * offset.v_px};
}

// The same warp, moved so that the point lies at `position`.
[[nodiscard]] inline AffineWarp moved_to(AffineWarp warp, ImagePoint offset, ImagePoint position) {
  const ImagePoint now = point_of(warp, offset);
  warp.u_px += position.u_px - now.u_px;
  warp.v_px += position.v_px - now.v_px;
  return warp;
}

// Where the right image shows a point.
[[nodiscard]] inline ImagePoint right_of(ImagePoint left, const StereoMeasurement& stereo) {
  return {left.u_px - stereo.disparity_px + stereo.skew_shift.u_px,
          left.v_px + stereo.skew_shift.v_px};
}

[[nodiscard]] bool holds_template(const ImageView& image, PixelPosition pixel);

// The followed points in ascending id and their anchor templates. Bounded by `capacity`; nothing is
// allocated after construction.
class TrackStore {
 public:
  explicit TrackStore(int capacity);

  [[nodiscard]] std::vector<FollowedPoint>& points() { return points_; }
  [[nodiscard]] const std::vector<FollowedPoint>& points() const { return points_; }
  [[nodiscard]] const AffineTemplate& anchor(const FollowedPoint& point) const {
    return anchors_[static_cast<std::size_t>(point.anchor)];
  }
  // Brings the template near: all of them do not fit into a core's own cache.
  void prefetch_anchor(const FollowedPoint& point) const {
    constexpr std::size_t kCacheLine = 64;
    const auto* bytes = reinterpret_cast<const char*>(&anchor(point));
    for (std::size_t i = 0; i < sizeof(AffineTemplate); i += kCacheLine)
      __builtin_prefetch(bytes + i);
  }
  [[nodiscard]] std::size_t free_places() const { return free_anchors_.size(); }
  [[nodiscard]] bool full() const { return free_anchors_.empty(); }

  // Renews the template at the point's own place in `left`; the point stays where it is.
  void anchor_here(const ImageView& left, FollowedPoint& point);
  // Appends a point with a fresh id, anchored at `pixel`. The store must not be full.
  FollowedPoint& add(const ImageView& left, PixelPosition pixel, CornerKind kind);
  void clear();
  // Drops points for which `lost(point)`; the others keep their order.
  template <typename Predicate>
  void drop_if(Predicate lost) {
    const auto dropped =
        std::remove_if(points_.begin(), points_.end(), [&](const FollowedPoint& p) {
          if (!lost(p)) return false;
          free_anchors_.push_back(p.anchor);
          return true;
        });
    points_.erase(dropped, points_.end());
  }

 private:
  std::uint64_t last_id_ = 0;
  std::vector<FollowedPoint> points_;
  std::vector<AffineTemplate> anchors_;
  std::vector<std::int32_t> free_anchors_;
};

}  // namespace egomod
