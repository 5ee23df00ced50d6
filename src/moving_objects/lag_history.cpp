// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/lag_history.hpp"

#include <algorithm>
#include <cmath>

#include "egomod/core/geometry.hpp"
#include "moving_objects/point_sample.hpp"

namespace egomod {
namespace {

Nanoseconds from_seconds(double seconds) {
  return Nanoseconds(static_cast<std::int64_t>(std::llround(seconds * 1e9)));
}

}  // namespace

LagHistory::LagHistory(const MovingObjectsConfig& config)
    : lag_(from_seconds(config.lag_s)),
      min_lag_(from_seconds(config.min_lag_s)),
      max_lag_(from_seconds(config.max_lag_s)) {
  for (Entry& entry : entries_) entry.observed.reserve(kReservedTracks);
}

void LagHistory::clear() { size_ = 0; }

void LagHistory::advance(const Egomotion& motion) {
  if (size_ > 0 && (motion.reset_count != reset_count_ || motion.exposure <= newest().exposure)) {
    clear();
  }
  reset_count_ = motion.reset_count;
  // T_e_c = T_e_p * T_p_c, each with a right perturbation: xi = Ad(T_c_p) xi_e_p + xi_p_c.
  const Matrix6d Ad = adjoint(motion.T_previous_current.inverse());
  for (std::size_t k = 0; k < size_; ++k) {
    Matrix6d& covariance = entries_[(next_ + kCapacity - 1 - k) % kCapacity].motion_covariance;
    const Matrix6d moved = Ad * covariance;
    covariance.noalias() = moved * Ad.transpose();
    covariance += motion.covariance_previous_current;
  }
}

std::span<const LagHistory::Entry* const> LagHistory::references(Nanoseconds now) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < size_; ++k) {
    const Entry& entry = entries_[(next_ + kCapacity - 1 - k) % kCapacity];
    const Nanoseconds lag = now - entry.exposure;
    if (lag >= min_lag_ && lag <= max_lag_) references_[count++] = &entry;
  }
  if (count == 0 && size_ > 0 && now - newest().exposure > max_lag_) {
    references_[count++] = &newest();
  }
  std::sort(references_.begin(), references_.begin() + static_cast<std::ptrdiff_t>(count),
            [&](const Entry* a, const Entry* b) {
              const auto off_a = std::chrono::abs(now - a->exposure - lag_);
              const auto off_b = std::chrono::abs(now - b->exposure - lag_);
              return off_a != off_b ? off_a < off_b : a->exposure < b->exposure;
            });
  return {references_.data(), count};
}

void LagHistory::push(const TrackSet& tracks, const Egomotion& motion) {
  // At high rates not every pair is worth its memory.
  if (size_ > 0 && motion.exposure - newest().exposure < lag_ / (kCapacity / 2)) return;
  Entry& entry = entries_[next_];
  next_ = (next_ + 1) % kCapacity;
  size_ = std::min(size_ + 1, kCapacity);
  entry.exposure = motion.exposure;
  entry.T_first_entry = motion.T_first_current;
  entry.motion_covariance.setZero();
  entry.observed.clear();
  for (const Track& track : tracks.tracks) {
    if (track.has_current) entry.observed.push_back({track.id, track.current});
  }
}

const StereoObservation* ObservationCursor::find(std::uint64_t id) {
  const auto& observed = entry_->observed;
  while (next_ < observed.size() && observed[next_].id < id) ++next_;
  return next_ < observed.size() && observed[next_].id == id ? &observed[next_].observation
                                                             : nullptr;
}

}  // namespace egomod
