// SPDX-License-Identifier: Apache-2.0
#include "mover_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace egomod {
namespace {

constexpr std::uint32_t kYoungAge = 3;
constexpr std::size_t kMinLost = 4;
constexpr float kOwnMotion_px = 6.0F;  // from where a point would rest
// Two points belong together within this distance in (u, v, 3 disparity).
constexpr float kTogether_px = 90.0F;
constexpr float kNear_px = 45.0F;
constexpr std::ptrdiff_t kMinLostNear = 3;  // itself among them
constexpr float kLostShare = 0.5F;
constexpr std::size_t kMaxSearches = 32;       // bounds the time of a pair,
constexpr std::size_t kMaxSearchesLong = 128;  // and of one for which there is time
constexpr int kLevel = 2;
constexpr int kWideRadius_px = PatchSearch::kMaxRadius_px;  // at kLevel: 128 px
constexpr int kRefineRadius_px = 4;                         // at half resolution
constexpr float kMinNcc = 0.8F;
constexpr float kMinLead = 0.03F;  // over the second best place
constexpr int kSamePeak_px = 2;    // at kLevel, in two windows
// Flows are shared within this, absolute (whole pixels of kLevel) or by share of their length.
constexpr float kSharedFlow_px = 6.0F;
constexpr float kSharedFlowShare = 0.08F;
constexpr int kMinCompanions = 2;
constexpr float kMinRefinedNcc = 0.85F;

template <typename Place>
float square_distance(const Place& a, const Place& b) {
  const float du = a.u_px - b.u_px, dv = a.v_px - b.v_px, dd = a.depth_px - b.depth_px;
  return du * du + dv * dv + dd * dd;
}

template <typename Place>
bool closer(const Place& a, const Place& b, float limit_px) {
  return square_distance(a, b) < limit_px * limit_px;
}

bool is_shared(ImagePoint a, ImagePoint b) {
  return distance(a, b) < std::max(kSharedFlow_px, kSharedFlowShare * length(a));
}

}  // namespace

MoverSearch::Place MoverSearch::place_of(const FollowedPoint& p, std::size_t index) {
  return {p.previous_left.u_px, p.previous_left.v_px, 3.0F * p.previous_stereo.disparity_px, index};
}

MoverSearch::MoverSearch(int capacity) {
  const auto n = static_cast<std::size_t>(capacity);
  lost_.reserve(n);
  chosen_.reserve(n);
  votes_.reserve(n + kMaxSearchesLong);
}

void MoverSearch::find_lost(const StereoImages& previous, const StereoImages& current,
                            const RigMotion& motion, bool is_long, TemporalAlignment& alignment,
                            TrackStore& store) {
  is_long_ = is_long;
  gather_lost(store);
  if (lost_.size() < kMinLost || current.left.levels() <= kLevel) return;
  choose_clustered(store);
  votes_.clear();
  vote_by_followed(motion, store);
  vote_by_search(previous, current, store);
  keep_shared();
  if (votes_.empty()) return;
  for (const Place& place : lost_) {
    const LocalFlows local = flows_around(place);
    if (local.count == 0) continue;
    alignment.follow_best(previous, current, store, {local.flows.data(), local.count},
                          kRefineRadius_px, kMinRefinedNcc, store.points()[place.index]);
  }
}

void MoverSearch::gather_lost(const TrackStore& store) {
  lost_.clear();
  for (std::size_t i = 0; i < store.points().size(); ++i) {
    const FollowedPoint& p = store.points()[i];
    if (p.followed || !p.has_previous_observation || p.age > kYoungAge) continue;
    lost_.push_back(
        {p.previous_left.u_px, p.previous_left.v_px, 3.0F * p.previous_stereo.disparity_px, i});
  }
}

// At rest in the scene, points are lost singly, between others that are found.
bool MoverSearch::mostly_lost_around(const Place& place, const TrackStore& store) const {
  const auto found =
      std::count_if(store.points().begin(), store.points().end(), [&](const FollowedPoint& p) {
        return p.followed && closer(place, place_of(p, 0), kNear_px);
      });
  const auto lost = std::count_if(lost_.begin(), lost_.end(), [&](const Place& other) {
    return closer(place, other, kNear_px);
  });
  return lost >= kMinLostNear &&
         static_cast<float>(lost) > kLostShare * static_cast<float>(lost + found);
}

// Evenly thinned where there are more than may be searched for.
void MoverSearch::choose_clustered(const TrackStore& store) {
  chosen_.clear();
  for (const Place& place : lost_)
    if (mostly_lost_around(place, store)) chosen_.push_back(place);
  const std::size_t most = is_long_ ? kMaxSearchesLong : kMaxSearches;
  if (chosen_.size() <= most) return;
  for (std::size_t k = 0; k < most; ++k) chosen_[k] = chosen_[k * chosen_.size() / most];
  chosen_.resize(most);
}

void MoverSearch::vote_by_followed(const RigMotion& motion, const TrackStore& store) {
  for (std::size_t i = 0; i < store.points().size(); ++i) {
    const FollowedPoint& p = store.points()[i];
    const auto resting = motion.predict(p);
    if (!p.followed || is_left_only(p) || !resting ||
        distance(resting->left, p.left) < kOwnMotion_px)
      continue;
    votes_.push_back({place_of(p, i), p.flow});
  }
}

void MoverSearch::vote_by_search(const StereoImages& previous, const StereoImages& current,
                                 const TrackStore& store) {
  for (const Place& place : chosen_) {
    const ImagePoint from = store.points()[place.index].previous_left;
    if (const auto flow = wide_flow(previous, current, from)) votes_.push_back({place, *flow});
  }
}

// Over a long interval, what crosses the image is beside the window, too.
PatchSearchResult MoverSearch::widest_search(const ImageView& image, const SearchPatch& patch,
                                             PixelPosition source) {
  PatchSearchResult best = search_.search(image, patch, source, kWideRadius_px);
  if (!is_long_) return best;
  for (const int step_px : {-2 * kWideRadius_px, 2 * kWideRadius_px}) {
    PixelPosition beside = source;
    beside.u_px += step_px;
    PatchSearchResult other = search_.search(image, patch, beside, kWideRadius_px);
    if (!other.found) continue;
    const bool is_same =
        std::max(std::abs(other.top_left.u_px - best.top_left.u_px),
                 std::abs(other.top_left.v_px - best.top_left.v_px)) <= kSamePeak_px;
    if (other.ncc > best.ncc) std::swap(other, best);
    best.second_ncc = std::max(best.second_ncc, is_same ? other.second_ncc : other.ncc);
  }
  return best;
}

std::optional<ImagePoint> MoverSearch::wide_flow(const StereoImages& previous,
                                                 const StereoImages& current, ImagePoint from) {
  const PixelPosition source = patch_top_left(to_level(from, kLevel));
  SearchPatch patch;
  if (!copy_patch(previous.left.level(kLevel), source, patch)) return std::nullopt;
  const PatchSearchResult best = widest_search(current.left.level(kLevel), patch, source);
  if (!best.found || best.ncc < kMinNcc || best.ncc < best.second_ncc + kMinLead)
    return std::nullopt;
  constexpr auto kScale = static_cast<float>(1 << kLevel);
  return ImagePoint{kScale * static_cast<float>(best.top_left.u_px - source.u_px),
                    kScale * static_cast<float>(best.top_left.v_px - source.v_px)};
}

void MoverSearch::keep_shared() {
  for (Vote& mine : votes_) {
    const auto agreeing = std::count_if(votes_.begin(), votes_.end(), [&](const Vote& other) {
      return closer(mine.place, other.place, kTogether_px) && is_shared(mine.flow, other.flow);
    });
    mine.shared = agreeing > kMinCompanions;  // it agrees with itself
  }
  std::erase_if(votes_, [](const Vote& v) { return !v.shared; });
}

// The flows of the nearest votes, different ones only.
MoverSearch::LocalFlows MoverSearch::flows_around(const Place& place) const {
  LocalFlows local;
  std::array<float, kMaxFlows> squares{};
  for (std::size_t k = 0; k < kMaxFlows; ++k) {
    const Vote* nearest = nullptr;
    for (const Vote& v : votes_) {
      const float square = square_distance(place, v.place);
      const bool known = std::any_of(
          local.flows.begin(), local.flows.begin() + static_cast<std::ptrdiff_t>(local.count),
          [&](ImagePoint f) { return distance(f, v.flow) < kSharedFlow_px; });
      if (known || square > kTogether_px * kTogether_px) continue;
      if (nearest != nullptr && square >= squares[k]) continue;
      nearest = &v;
      squares[k] = square;
    }
    if (nearest == nullptr) break;
    local.flows[local.count++] = nearest->flow;
  }
  return local;
}

}  // namespace egomod
