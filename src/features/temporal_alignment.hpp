// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "egomod/features/patch_search.hpp"
#include "rig_motion.hpp"
#include "stereo_images.hpp"
#include "track_store.hpp"

namespace egomod {

// Finds known points in the current left image: predicted, searched for on a coarse level, then
// aligned to their anchor templates. Points that are found have `followed` set. Threads: one
// caller.
class TemporalAlignment {
 public:
  explicit TemporalAlignment(int capacity) {
    neighbours_.reserve(static_cast<std::size_t>(capacity));
  }

  // Points that rested so far, expected where they rest under `motion`, others to go on as they
  // moved; without any motion known, all from where they were. `scouts` are few and spread evenly:
  // enough to tell the rig's motion.
  enum class Part { kScouts, kOthers };
  void follow_expected(Part part, const RigMotion& motion, const StereoImages& previous,
                       const StereoImages& current, TrackStore& store);
  // The points not found yet: where they are if they rest and the rig moved as `motion` says. Young
  // points found elsewhere look there as well, and stay where they fit better.
  void follow_rig(const RigMotion& motion, const StereoImages& current, TrackStore& store);
  // Who was seen where it would rest, and how far from there.
  static void remember_resting(const RigMotion& motion, TrackStore& store);
  // The points not found yet: as their nearest neighbours moved in this pair, or not at all, since
  // a point may belong to something that moves with the rig; whichever fits better.
  void follow_neighbours(const RigMotion& motion, const StereoImages& previous,
                         const StereoImages& current, TrackStore& store);
  // Gives up points whose flow hardly any of their neighbours shares: in a wide search things that
  // merely look alike are found often, and each of them somewhere else.
  void give_up_loners(TrackStore& store);
  // The same for young points that do not rest, by how they differ from resting ones: points of one
  // mover agree.
  void give_up_young_loners(const RigMotion& motion, TrackStore& store);
  // One point, expected to have moved by one of `flows`: the one that fits best, if well enough.
  void follow_best(const StereoImages& previous, const StereoImages& current,
                   const TrackStore& store, std::span<const ImagePoint> flows, int radius_px,
                   float min_ncc, FollowedPoint& point);
  // One point, expected at `expected` with an uncertain scale.
  void follow_to(const StereoImages& current, const TrackStore& store, ImagePoint expected,
                 FollowedPoint& point);

 private:
  struct Neighbour {
    float u_px, v_px, depth_px;
    ImagePoint flow;
    std::uint64_t id;
  };
  struct Attempt {
    AffineWarp warp;
    float ncc = -1.0F;
  };
  // Growth: of the view since the previous pair.
  struct Expectation {
    ImagePoint left;
    float growth = 1.0F;
  };
  template <std::size_t kCount>
  using Flows = std::array<ImagePoint, kCount>;

  [[nodiscard]] Attempt align_from(const StereoImages& current, const TrackStore& store,
                                   const FollowedPoint& point, const Expectation& expected) const;
  [[nodiscard]] Attempt search_and_align(const StereoImages& previous, const StereoImages& current,
                                         const TrackStore& store, const FollowedPoint& point,
                                         const Expectation& expected, int radius_px);
  void follow_one(const RigMotion& motion, bool any_motion, const StereoImages& previous,
                  const StereoImages& current, const TrackStore& store, FollowedPoint& point);
  // Nothing where no place looks like it; the prediction where it cannot be searched for.
  [[nodiscard]] std::optional<ImagePoint> search(const StereoImages& previous,
                                                 const StereoImages& current, ImagePoint from,
                                                 ImagePoint predicted, int radius_px);
  void gather_neighbours(const TrackStore& store);
  void gather_own_motions(const RigMotion& motion, const TrackStore& store);
  template <std::size_t kCount>
  [[nodiscard]] std::size_t nearest_flows(const FollowedPoint& point, Flows<kCount>& flows) const;
  [[nodiscard]] ImagePoint neighbours_flow(const FollowedPoint& point) const;
  [[nodiscard]] bool is_loner(const FollowedPoint& point, ImagePoint flow) const;

  PatchSearch search_;
  std::vector<Neighbour> neighbours_;
};

}  // namespace egomod
