// SPDX-License-Identifier: Apache-2.0
#include "temporal_alignment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

namespace egomod {
namespace {

constexpr int kMaxSteps = 10;
constexpr float kMinNcc = 0.75F;
constexpr float kMinDeterminant = 0.3F;
constexpr float kMaxDeviation = 1.2F;
constexpr float kMaxCorrection_px = 3.0F;  // beyond what the coarse search found
constexpr float kBorder_px = 9.0F;
constexpr float kSuspiciousNccDrop = 0.1F;
constexpr float kRestingMargin = 0.02F;
constexpr float kClearNcc = 0.9F;  // no other scale needs to be tried
// Flow that neighbours share, of eight: this near to each other, absolute or by share of its
// length.
constexpr float kSharedFlow_px = 5.0F;
constexpr float kSharedFlowShare = 0.2F;
constexpr std::ptrdiff_t kMinCompanions = 3;
// A point that is further from where it would rest has a motion of its own, or is a look-alike.
constexpr float kResting_px = 4.0F;
constexpr float kMoving_px = 0.7F;  // a pair, by a motion of its own; less may be noise
constexpr std::uint32_t kYoungAge = 3;
constexpr std::size_t kScouts = 150;
constexpr float kTellingDisparity_px = 3.0F;  // smaller ones are too noisy to tell growth
constexpr float kMaxGrowth = 1.3F;            // a pair
// By how much NCC must be better: elsewhere than at rest for a young point, at rest than elsewhere
// for an old one, which has rested so far.
constexpr float kOwnMotionLead = 0.05F;
constexpr float kRestLead = 0.02F;

// Of the half-resolution search. Constant motion errs by a few pixels; a new point's may be new.
constexpr int kSearchLevel = 1;
constexpr int kOldRadius_px = 4;
constexpr int kNewRadius_px = 8;
constexpr float kMinSearchNcc = 0.55F;  // of the best place: below, the point is not there

float deviation(const AffineWarp& w) {
  return std::sqrt((w.a - 1) * (w.a - 1) + w.b * w.b + w.c * w.c + (w.d - 1) * (w.d - 1));
}

bool well_inside(const ImageView& image, ImagePoint p) {
  return p.u_px > kBorder_px && p.v_px > kBorder_px &&
         p.u_px < static_cast<float>(image.width_px) - kBorder_px &&
         p.v_px < static_cast<float>(image.height_px) - kBorder_px;
}

bool plausible(const ImageView& image, const AffineWarp& warp, ImagePoint offset) {
  return warp.a * warp.d - warp.b * warp.c > kMinDeterminant && deviation(warp) < kMaxDeviation &&
         well_inside(image, point_of(warp, offset));
}

AffineWarp grown(AffineWarp warp, float growth) {
  warp.a *= growth;
  warp.b *= growth;
  warp.c *= growth;
  warp.d *= growth;
  return warp;
}

void accept(const AffineWarp& warp, float ncc, FollowedPoint& point) {
  if (ncc < kMinNcc) return;
  point.followed = true;
  point.warp = warp;
  point.ncc = ncc;
  const ImagePoint now = point_of(warp, point.offset);
  point.flow = now - point.previous_left;
  point.has_flow = true;
  point.left = now;
}

float median(std::array<float, 5> values) {
  std::sort(values.begin(), values.end());
  return values[2];
}

}  // namespace

std::optional<ImagePoint> TemporalAlignment::search(const StereoImages& previous,
                                                    const StereoImages& current, ImagePoint from,
                                                    ImagePoint predicted, int radius_px) {
  const int level = std::min(kSearchLevel, current.left.levels() - 1);
  const PixelPosition source = patch_top_left(to_level(from, level));
  SearchPatch patch;
  if (!copy_patch(previous.left.level(level), source, patch)) return predicted;
  const PixelPosition start = patch_top_left(to_level(predicted, level));
  const PatchSearchResult best = search_.search(current.left.level(level), patch, start, radius_px);
  if (!best.found) return predicted;
  if (best.ncc < kMinSearchNcc) return std::nullopt;
  const auto scale = static_cast<float>(1 << level);
  return ImagePoint{from.u_px + scale * static_cast<float>(best.top_left.u_px - source.u_px),
                    from.v_px + scale * static_cast<float>(best.top_left.v_px - source.v_px)};
}

TemporalAlignment::Attempt TemporalAlignment::align_from(const StereoImages& current,
                                                         const TrackStore& store,
                                                         const FollowedPoint& point,
                                                         const Expectation& expected) const {
  const ImagePoint start = expected.left;
  Attempt attempt{.warp =
                      moved_to(grown(point.previous_warp, expected.growth), point.offset, start)};
  const ImageView image = current.left.level(0);
  const AlignmentResult result = align(image, store.anchor(point), kMaxSteps, attempt.warp);
  const bool converged =
      result.converged && distance(point_of(attempt.warp, point.offset), start) < kMaxCorrection_px;
  if (converged && plausible(image, attempt.warp, point.offset)) attempt.ncc = result.ncc;
  return attempt;
}

TemporalAlignment::Attempt TemporalAlignment::search_and_align(
    const StereoImages& previous, const StereoImages& current, const TrackStore& store,
    const FollowedPoint& point, const Expectation& expected, int radius_px) {
  const std::optional<ImagePoint> found =
      search(previous, current, point.previous_left, expected.left, radius_px);
  return found ? align_from(current, store, point, {*found, expected.growth}) : Attempt{};
}

void TemporalAlignment::follow_expected(Part part, const RigMotion& motion,
                                        const StereoImages& previous, const StereoImages& current,
                                        TrackStore& store) {
  std::vector<FollowedPoint>& points = store.points();
  const bool any_motion =
      std::any_of(points.begin(), points.end(), [](const FollowedPoint& p) { return p.has_flow; });
  const std::size_t stride = 1 + points.size() / kScouts;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if ((i % stride == stride / 2) != (part == Part::kScouts)) continue;
    if (const std::size_t next = i + (part == Part::kScouts ? stride : 1); next < points.size())
      store.prefetch_anchor(points[next]);
    follow_one(motion, any_motion, previous, current, store, points[i]);
  }
}

void TemporalAlignment::follow_one(const RigMotion& motion, bool any_motion,
                                   const StereoImages& previous, const StereoImages& current,
                                   const TrackStore& store, FollowedPoint& point) {
  const float disparity_px = point.previous_stereo.disparity_px;
  point.expected_disparity_px = std::max(disparity_px + point.disparity_rate_px, 0.0F);
  Expectation expected{.left = point.previous_left + point.flow};
  const auto resting = point.rests ? motion.predict(point) : std::nullopt;
  if (resting) {
    point.expected_disparity_px = resting->disparity_px;
    expected.left = resting->left;
  } else if (any_motion && !point.has_flow) {
    return;
  }
  if (disparity_px > kTellingDisparity_px)
    expected.growth =
        std::clamp(point.expected_disparity_px / disparity_px, 1.0F / kMaxGrowth, kMaxGrowth);
  Attempt best = align_from(current, store, point, expected);
  if (best.ncc < point.usual_ncc - kSuspiciousNccDrop) {
    const bool known = resting || any_motion;
    best = search_and_align(previous, current, store, point, expected,
                            known ? kOldRadius_px : kNewRadius_px);
  }
  accept(best.warp, best.ncc, point);
}

void TemporalAlignment::remember_resting(const RigMotion& motion, TrackStore& store) {
  for (FollowedPoint& point : store.points()) {
    const auto resting = motion.predict(point);
    point.own_motion = {};
    if (!point.followed || !resting) continue;
    point.own_motion = point.left - resting->left;
    point.rests = length(point.own_motion) < kResting_px;
    point.pairs_moving = length(point.own_motion) > kMoving_px ? point.pairs_moving + 1 : 0;
  }
}

void TemporalAlignment::gather_neighbours(const TrackStore& store) {
  neighbours_.clear();
  for (const FollowedPoint& p : store.points()) {
    if (!p.followed || is_left_only(p)) continue;
    neighbours_.push_back({p.previous_left.u_px, p.previous_left.v_px,
                           3.0F * p.previous_stereo.disparity_px, p.flow, p.id});
  }
}

// The nearest in (u, v, 3 disparity): neighbours in space, not only in the image.
template <std::size_t kCount>
std::size_t TemporalAlignment::nearest_flows(const FollowedPoint& point,
                                             Flows<kCount>& flows) const {
  std::array<float, kCount> squares;
  squares.fill(std::numeric_limits<float>::max());
  std::size_t found = 0;
  const float depth = 3.0F * point.previous_stereo.disparity_px;
  for (const Neighbour& n : neighbours_) {
    const float du = n.u_px - point.previous_left.u_px;
    const float dv = n.v_px - point.previous_left.v_px;
    const float dd = n.depth_px - depth;
    const float square = du * du + dv * dv + dd * dd;
    if (square >= squares.back() || n.id == point.id) continue;
    std::size_t k = kCount - 1;
    for (; k > 0 && squares[k - 1] > square; --k) {
      squares[k] = squares[k - 1];
      flows[k] = flows[k - 1];
    }
    squares[k] = square;
    flows[k] = n.flow;
    found = std::min(found + 1, kCount);
  }
  return found;
}

ImagePoint TemporalAlignment::neighbours_flow(const FollowedPoint& point) const {
  Flows<5> flows{};
  if (nearest_flows(point, flows) < flows.size()) return flows[0];
  std::array<float, 5> u{};
  std::array<float, 5> v{};
  for (std::size_t k = 0; k < flows.size(); ++k) {
    u[k] = flows[k].u_px;
    v[k] = flows[k].v_px;
  }
  return {median(u), median(v)};
}

void TemporalAlignment::follow_rig(const RigMotion& motion, const StereoImages& current,
                                   TrackStore& store) {
  for (FollowedPoint& point : store.points()) {
    if (point.followed && point.age > kYoungAge && !point.rests) continue;
    const auto expected = motion.predict(point);
    if (!expected || (point.followed && distance(expected->left, point.left) < kResting_px))
      continue;
    const Attempt resting = align_from(current, store, point, {expected->left});
    const float lead = point.age > kYoungAge ? kRestLead : -kOwnMotionLead;
    const float rival = point.followed ? point.ncc + lead : point.usual_ncc - kSuspiciousNccDrop;
    if (resting.ncc > rival) accept(resting.warp, resting.ncc, point);
  }
}

void TemporalAlignment::follow_neighbours(const RigMotion& motion, const StereoImages& previous,
                                          const StereoImages& current, TrackStore& store) {
  gather_neighbours(store);
  for (FollowedPoint& point : store.points()) {
    // What rested for some pairs and is not where it would rest is hidden, or gone.
    const bool hidden = point.rests && point.age > kYoungAge && motion.predict(point);
    if (point.followed || hidden) continue;
    const ImagePoint flow = neighbours_flow(point);
    Attempt best = search_and_align(previous, current, store, point, {point.previous_left + flow},
                                    kNewRadius_px);
    // Within the search radius, resting was among the places searched.
    const float searched_px = static_cast<float>(kNewRadius_px << kSearchLevel);
    if (length(flow) > 0.5F * searched_px) {
      const Attempt resting =
          search_and_align(previous, current, store, point, {point.previous_left}, kNewRadius_px);
      if (resting.ncc > best.ncc + kRestingMargin) best = resting;
    }
    accept(best.warp, best.ncc, point);
  }
}

bool TemporalAlignment::is_loner(const FollowedPoint& point, ImagePoint flow) const {
  Flows<8> flows{};
  const std::size_t count = nearest_flows(point, flows);
  const float tolerance_px = std::max(kSharedFlow_px, kSharedFlowShare * length(flow));
  const auto companions =
      std::count_if(flows.begin(), flows.begin() + static_cast<std::ptrdiff_t>(count),
                    [&](ImagePoint f) { return distance(f, flow) < tolerance_px; });
  return companions < kMinCompanions;
}

void TemporalAlignment::give_up_loners(TrackStore& store) {
  gather_neighbours(store);
  for (FollowedPoint& point : store.points()) {
    if (point.followed && is_loner(point, point.flow)) point.followed = false;
  }
}

void TemporalAlignment::gather_own_motions(const RigMotion& motion, const TrackStore& store) {
  neighbours_.clear();
  for (const FollowedPoint& p : store.points()) {
    const auto resting = motion.predict(p);
    if (!p.followed || is_left_only(p) || !resting) continue;
    neighbours_.push_back({p.previous_left.u_px, p.previous_left.v_px,
                           3.0F * p.previous_stereo.disparity_px, p.left - resting->left, p.id});
  }
}

void TemporalAlignment::give_up_young_loners(const RigMotion& motion, TrackStore& store) {
  gather_own_motions(motion, store);
  for (FollowedPoint& point : store.points()) {
    const auto resting = motion.predict(point);
    if (!point.followed || point.age > kYoungAge || !resting) continue;
    const ImagePoint own = point.left - resting->left;
    if (length(own) > kResting_px && is_loner(point, own)) point.followed = false;
  }
}

void TemporalAlignment::follow_best(const StereoImages& previous, const StereoImages& current,
                                    const TrackStore& store, std::span<const ImagePoint> flows,
                                    int radius_px, float min_ncc, FollowedPoint& point) {
  Attempt best;
  for (const ImagePoint flow : flows) {
    const Attempt attempt =
        search_and_align(previous, current, store, point, {point.previous_left + flow}, radius_px);
    if (attempt.ncc > best.ncc) best = attempt;
  }
  if (best.ncc >= min_ncc) accept(best.warp, best.ncc, point);
}

void TemporalAlignment::follow_to(const StereoImages& current, const TrackStore& store,
                                  ImagePoint expected, FollowedPoint& point) {
  const ImageView image = current.left.level(0);
  Attempt best;
  for (const float scale : {1.0F, 0.83F, 1.2F}) {
    AffineWarp warp = moved_to(grown(point.previous_warp, scale), point.offset, expected);
    const AlignmentResult result = align(image, store.anchor(point), 2 * kMaxSteps, warp);
    const bool near = distance(point_of(warp, point.offset), expected) < 2 * kMaxCorrection_px;
    if (result.converged && near && result.ncc > best.ncc && plausible(image, warp, point.offset)) {
      best = {warp, result.ncc};
      if (best.ncc > kClearNcc) break;
    }
  }
  accept(best.warp, best.ncc, point);
}

}  // namespace egomod
