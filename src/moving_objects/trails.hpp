// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "egomod/core/time.hpp"
#include "moving_objects/point_sample.hpp"

namespace egomod {

// Where points were measured in the last pairs, in axes that do not move, and how fast they went
// over the last few: noisier than a filter, but free of all that is older. Memory is bounded.
class Trails {
 public:
  Trails();

  // The next pair; what was before a reset is not comparable.
  void begin(Nanoseconds now, bool anew);
  // Of this pair. `is_new`: it is another point that had this place before.
  void add(std::size_t place, const Eigen::Vector3d& position_m, bool is_new);
  // Over all windows in which the point was measured without a gap; `R` turns them to other axes.
  [[nodiscard]] RecentVelocities velocities(std::size_t place, const Eigen::Matrix3d& R) const;

 private:
  static constexpr std::size_t kPairs = 16;  // no fewer than the longest window has
  // Least squares: the velocity is the sum of positions times weights, the latest first.
  struct Window {
    std::array<double, kPairs> weights_hz{};
    double span_s = 0.0;
    double gain_hz2 = 0.0;  // the velocity's variance by that of a position
  };
  struct Seen {
    std::int64_t first = 0;  // without a gap since
    std::int64_t last = -1;
  };

  [[nodiscard]] static std::size_t row(std::int64_t pair) {
    return static_cast<std::size_t>(pair) % kPairs;
  }
  [[nodiscard]] Window window(std::size_t pairs) const;

  std::int64_t pair_ = 0;
  std::int64_t first_ = 0;  // comparable
  std::array<Nanoseconds, kPairs> exposures_{};
  std::array<std::vector<Eigen::Vector3d>, kPairs> positions_m_;
  std::vector<Seen> seen_;
  std::array<Window, kRecentPairs.size()> windows_;
  std::size_t count_ = 0;  // of windows
};

}  // namespace egomod
