// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/trails.hpp"

#include <algorithm>

namespace egomod {
namespace {

constexpr double kLongest_s = 0.41;

}  // namespace

Trails::Trails() {
  for (auto& row : positions_m_) row.reserve(kReservedTracks);
  seen_.reserve(kReservedTracks);
}

Trails::Window Trails::window(std::size_t pairs) const {
  Window window;
  double mean_s = 0.0;
  for (std::size_t k = 0; k < pairs; ++k) {
    const Nanoseconds age = exposures_[row(pair_)] - exposures_[row(pair_ - static_cast<int>(k))];
    window.span_s = to_seconds(age);
    window.weights_hz[k] = -window.span_s;
    mean_s -= window.span_s / static_cast<double>(pairs);
  }
  double sum_s2 = 0.0;
  for (std::size_t k = 0; k < pairs; ++k) {
    window.weights_hz[k] -= mean_s;
    sum_s2 += window.weights_hz[k] * window.weights_hz[k];
  }
  window.gain_hz2 = 1.0 / sum_s2;
  for (double& weight : window.weights_hz) weight *= window.gain_hz2;
  return window;
}

void Trails::begin(Nanoseconds now, bool anew) {
  ++pair_;
  if (anew) first_ = pair_;
  exposures_[row(pair_)] = now;
  for (count_ = 0; count_ < kRecentPairs.size(); ++count_) {
    const std::size_t pairs = kRecentPairs[count_];
    if (pair_ - first_ + 1 < static_cast<std::int64_t>(pairs)) return;
    windows_[count_] = window(pairs);
    if (windows_[count_].span_s > kLongest_s) return;
  }
}

void Trails::add(std::size_t place, const Eigen::Vector3d& position_m, bool is_new) {
  if (seen_.size() <= place) {
    seen_.resize(place + 1);
    for (auto& row : positions_m_) row.resize(place + 1);
  }
  Seen& seen = seen_[place];
  if (is_new || seen.last != pair_ - 1 || seen.first < first_) seen.first = pair_;
  seen.last = pair_;
  positions_m_[row(pair_)][place] = position_m;
}

RecentVelocities Trails::velocities(std::size_t place, const Eigen::Matrix3d& R) const {
  RecentVelocities recent;
  const Seen& seen = seen_[place];
  if (seen.last != pair_) return recent;
  for (; recent.count < count_; ++recent.count) {
    const std::size_t pairs = kRecentPairs[recent.count];
    if (pair_ - seen.first + 1 < static_cast<std::int64_t>(pairs)) break;
    const Window& window = windows_[recent.count];
    Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < pairs; ++k) {
      velocity_mps += window.weights_hz[k] * positions_m_[row(pair_ - static_cast<int>(k))][place];
    }
    recent.windows[recent.count] = {R * velocity_mps, window.gain_hz2, window.span_s};
  }
  return recent;
}

}  // namespace egomod
