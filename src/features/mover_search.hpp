// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "egomod/features/patch_search.hpp"
#include "rig_motion.hpp"
#include "stereo_images.hpp"
#include "temporal_alignment.hpp"
#include "track_store.hpp"

namespace egomod {

// Finds the new points of something that moves fast against its surroundings, so that neither rest
// nor the motion of the neighbours predicts them. Where new points are lost together, some are
// searched for in a wide window of the coarsest level; only motions that several of them share
// count, and the other lost points around them are expected to move likewise.
// Threads: one caller.
class MoverSearch {
 public:
  explicit MoverSearch(int capacity);

  void find_lost(const StereoImages& previous, const StereoImages& current, const RigMotion& motion,
                 bool is_long, TemporalAlignment& alignment, TrackStore& store);

 private:
  struct Place {  // of a point in the previous pair
    float u_px, v_px;
    float depth_px;  // 3 disparity
    std::size_t index;
  };
  struct Vote {
    Place place;
    ImagePoint flow;
    bool shared = false;
  };
  static constexpr std::size_t kMaxFlows = 3;
  struct LocalFlows {
    std::array<ImagePoint, kMaxFlows> flows{};
    std::size_t count = 0;
  };

  [[nodiscard]] static Place place_of(const FollowedPoint& point, std::size_t index);
  void gather_lost(const TrackStore& store);
  void choose_clustered(const TrackStore& store);
  [[nodiscard]] bool mostly_lost_around(const Place& place, const TrackStore& store) const;
  void vote_by_followed(const RigMotion& motion, const TrackStore& store);
  void vote_by_search(const StereoImages& previous, const StereoImages& current,
                      const TrackStore& store);
  [[nodiscard]] std::optional<ImagePoint> wide_flow(const StereoImages& previous,
                                                    const StereoImages& current, ImagePoint from);
  [[nodiscard]] PatchSearchResult widest_search(const ImageView& image, const SearchPatch& patch,
                                                PixelPosition source);
  void keep_shared();
  [[nodiscard]] LocalFlows flows_around(const Place& place) const;

  bool is_long_ = false;
  PatchSearch search_;
  std::vector<Place> lost_;
  std::vector<Place> chosen_;
  std::vector<Vote> votes_;
};

}  // namespace egomod
