// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "motion.hpp"

namespace egomod::sim {

// What the base shall do from a simulated time on. Counter-clockwise seen from above is positive.
struct DriveCommand {
  double from_s = 0.0;
  double linear_mps = 0.0;
  double angular_radps = 0.0;
  double until_s = std::numeric_limits<double>::infinity();
};

// A Pioneer P3-DX, unless said otherwise.
struct Drive {
  PlanPose start{};
  double max_speed_mps = 1.2;
  double max_turn_radps = 300.0 * M_PI / 180.0;
  double acceleration_mps2 = 0.3;
  double turn_acceleration_radps2 = 100.0 * M_PI / 180.0;
  double lag_s = 0.1;       // of the wheels behind the speed that the controller sets
  double watchdog_s = 2.0;  // without a command for this long it stops
  double odometry_rate_hz = 50.0;
  double wheel_slip = 0.0;                // share of the wheels' way that is none of the base's
  double wheel_noise_m_per_sqrt_m = 0.0;  // each wheel's random walk over its way
  double wheel_track_m = 0.33;
  double radius_m = 0.25;
  std::vector<DriveCommand> script{};  // in order of time
};

// The floor that it stands on.
struct Floor {
  double x_min_m = 0.0, x_max_m = 0.0, z_min_m = 0.0, z_max_m = 0.0;
};

struct BaseState {
  PlanPose pose;
  double way_m = 0.0;  // backwards is negative
  double linear_mps = 0.0;
  double angular_radps = 0.0;
  bool stalled = false;  // it pushes against a wall
  // What its wheels tell: x forward and y left at the start, counter-clockwise.
  double odometry_x_m = 0.0;
  double odometry_y_m = 0.0;
  double odometry_heading_rad = 0.0;
};

// A base on two driven wheels that obeys commands with limits and lag: its controller approaches
// the commanded speeds at limited acceleration, its wheels follow the controller with a first-order
// lag. Time is cut into ticks, so that a run depends on its commands only, not on when it is asked
// to go on. Threads: one caller.
class DrivenBase {
 public:
  static constexpr double kTick_s = 0.005;

  DrivenBase(const Drive& drive, const Floor& floor, std::uint32_t seed);

  // Takes effect at its time, or at `now_s` if that is over.
  void accept(const DriveCommand& command);
  // Goes on until the time given, at least.
  void advance(double until_s);
  [[nodiscard]] double now_s() const { return kTick_s * static_cast<double>(tick_); }
  // Between ticks as within them; of the last kMemory_s and of the start, else the nearest known.
  [[nodiscard]] BaseState at(double t_s) const;
  [[nodiscard]] const Drive& drive() const { return drive_; }

 private:
  static constexpr double kMemory_s = 3.0;

  struct Speeds {
    double linear_mps = 0.0;
    double angular_radps = 0.0;
  };
  void tick();
  [[nodiscard]] Speeds wanted(double t_s);
  [[nodiscard]] bool is_inside(const PlanPose& pose) const;
  void count_wheels(double way_m, double turn_rad, BaseState& state);

  Drive drive_;
  Floor floor_;
  std::mt19937 noise_;
  std::deque<DriveCommand> commands_;  // ascending; the first may be in force
  Speeds set_;                         // by the controller
  BaseState start_;
  std::deque<BaseState> states_;  // one a tick, the last is now
  std::int64_t tick_ = 0;
};

}  // namespace egomod::sim
