// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/core/egomotion.hpp"
#include "egomod/core/time.hpp"
#include "egomod/core/track_set.hpp"
#include "egomod/moving_objects/moving_objects_config.hpp"

namespace egomod {

// The last pairs, about 2 * lag_s deep at any rate: what each track looked like, where the rig was,
// and how uncertain the motion since then is. Memory is bounded and taken at construction.
class LagHistory {
 public:
  struct Observed {
    std::uint64_t id;
    StereoObservation observation;
  };
  struct Entry {
    Nanoseconds exposure{0};
    Eigen::Isometry3d T_first_entry = Eigen::Isometry3d::Identity();
    Matrix6d motion_covariance = Matrix6d::Zero();  // of T_entry_current, right perturbation
    std::vector<Observed> observed;                 // ascending id
  };

  explicit LagHistory(const MovingObjectsConfig& config);

  // Takes the step to the current pair into account: forgets what a reset or a backward clock made
  // incomparable, adds the step's covariance to the rest.
  void advance(const Egomotion& motion);
  // Entries to compare the current pair with, the nearest to the lag first: those within
  // [min_lag_s, max_lag_s], or at a lower rate the previous one. Valid until `push`.
  [[nodiscard]] std::span<const Entry* const> references(Nanoseconds now);
  // Keeps the current pair, once `advance` has been called for it.
  void push(const TrackSet& tracks, const Egomotion& motion);

 private:
  static constexpr std::size_t kCapacity = 32;

  void clear();
  [[nodiscard]] Entry& newest() { return entries_[(next_ + kCapacity - 1) % kCapacity]; }

  const Nanoseconds lag_;
  const Nanoseconds min_lag_;
  const Nanoseconds max_lag_;
  std::array<Entry, kCapacity> entries_;
  std::array<const Entry*, kCapacity> references_{};
  std::size_t next_ = 0;
  std::size_t size_ = 0;
  std::uint32_t reset_count_ = 0;
};

// Looks up ascending track ids in an entry in one pass.
class ObservationCursor {
 public:
  explicit ObservationCursor(const LagHistory::Entry& entry) : entry_(&entry) {}
  // `id` must not fall from call to call.
  [[nodiscard]] const StereoObservation* find(std::uint64_t id);
  [[nodiscard]] const LagHistory::Entry& entry() const { return *entry_; }

 private:
  const LagHistory::Entry* entry_;
  std::size_t next_ = 0;
};

}  // namespace egomod
