// SPDX-License-Identifier: Apache-2.0
#include "driven_base.hpp"

#include <algorithm>
#include <cmath>

namespace egomod::sim {
namespace {

double approached(double from, double to, double step) {
  return from + std::clamp(to - from, -step, step);
}

// Along an arc, exactly; a turn to the right is positive here.
PlanPose moved(const PlanPose& from, double way_m, double turn_rad) {
  const double half = 0.5 * turn_rad;
  const double chord_m = std::abs(half) < 1e-9 ? way_m : way_m * std::sin(half) / half;
  const double direction = from.heading_rad + half;
  return {from.x_m + chord_m * std::sin(direction), from.z_m + chord_m * std::cos(direction),
          from.heading_rad + turn_rad};
}

}  // namespace

DrivenBase::DrivenBase(const Drive& drive, const Floor& floor, std::uint32_t seed)
    : drive_(drive), floor_(floor), noise_(seed) {
  start_.pose = drive.start;
  states_.push_back(start_);
  for (const DriveCommand& command : drive.script) accept(command);
}

// Of two for the same time the later one counts.
void DrivenBase::accept(const DriveCommand& command) {
  DriveCommand timed = command;
  timed.from_s = std::max(timed.from_s, now_s());
  const auto place = std::ranges::upper_bound(commands_, timed.from_s, {}, &DriveCommand::from_s);
  commands_.insert(place, timed);
}

void DrivenBase::advance(double until_s) {
  while (now_s() < until_s) tick();
}

DrivenBase::Speeds DrivenBase::wanted(double t_s) {
  while (commands_.size() > 1 && commands_[1].from_s <= t_s) commands_.pop_front();
  if (commands_.empty()) return {};
  const DriveCommand& command = commands_.front();
  if (t_s < command.from_s || t_s >= command.until_s) return {};
  return {std::clamp(command.linear_mps, -drive_.max_speed_mps, drive_.max_speed_mps),
          std::clamp(command.angular_radps, -drive_.max_turn_radps, drive_.max_turn_radps)};
}

bool DrivenBase::is_inside(const PlanPose& pose) const {
  const double r = drive_.radius_m;
  return pose.x_m >= floor_.x_min_m + r && pose.x_m <= floor_.x_max_m - r &&
         pose.z_m >= floor_.z_min_m + r && pose.z_m <= floor_.z_max_m - r;
}

// Speeds change linearly within a tick, so that the mean of both ends is exact for ramps.
void DrivenBase::tick() {
  const BaseState& before = states_.back();
  const Speeds goal = wanted(now_s());
  set_.linear_mps =
      approached(set_.linear_mps, goal.linear_mps, drive_.acceleration_mps2 * kTick_s);
  set_.angular_radps =
      approached(set_.angular_radps, goal.angular_radps, drive_.turn_acceleration_radps2 * kTick_s);
  const double share = drive_.lag_s > 0.0 ? -std::expm1(-kTick_s / drive_.lag_s) : 1.0;
  BaseState after = before;
  after.linear_mps += share * (set_.linear_mps - before.linear_mps);
  after.angular_radps += share * (set_.angular_radps - before.angular_radps);
  const double way_m = 0.5 * kTick_s * (before.linear_mps + after.linear_mps);
  const double turn_rad = 0.5 * kTick_s * (before.angular_radps + after.angular_radps);
  after.pose = moved(before.pose, way_m, -turn_rad);
  after.stalled = !is_inside(after.pose) && way_m != 0.0;
  if (after.stalled) {
    after.pose = moved(before.pose, 0.0, -turn_rad);
    after.linear_mps = 0.0;
  }
  after.way_m += after.stalled ? 0.0 : way_m;
  count_wheels(after.stalled ? 0.0 : way_m, turn_rad, after);
  states_.push_back(after);
  ++tick_;
  if (kTick_s * static_cast<double>(states_.size()) > kMemory_s) states_.pop_front();
}

void DrivenBase::count_wheels(double way_m, double turn_rad, BaseState& state) {
  std::normal_distribution<double> normal;
  const auto counted = [&](double wheel_m) {
    const double sigma_m = drive_.wheel_noise_m_per_sqrt_m * std::sqrt(std::abs(wheel_m));
    return wheel_m / (1.0 - drive_.wheel_slip) + sigma_m * normal(noise_);
  };
  const double left_m = counted(way_m - 0.5 * drive_.wheel_track_m * turn_rad);
  const double right_m = counted(way_m + 0.5 * drive_.wheel_track_m * turn_rad);
  const double turned_rad = (right_m - left_m) / drive_.wheel_track_m;
  const double gone_m = 0.5 * (left_m + right_m);
  const double direction = state.odometry_heading_rad + 0.5 * turned_rad;
  state.odometry_x_m += gone_m * std::cos(direction);
  state.odometry_y_m += gone_m * std::sin(direction);
  state.odometry_heading_rad = std::remainder(state.odometry_heading_rad + turned_rad, 2.0 * M_PI);
}

BaseState DrivenBase::at(double t_s) const {
  if (t_s <= 0.0) return start_;
  const double first_s = now_s() - kTick_s * static_cast<double>(states_.size() - 1);
  const double ticks = std::max(0.0, (t_s - first_s) / kTick_s);
  const auto index = static_cast<std::size_t>(ticks);
  if (index + 1 >= states_.size()) return states_.back();
  BaseState state = states_[index];
  const BaseState& next = states_[index + 1];
  const double share = ticks - static_cast<double>(index);
  const auto covered = [&](double from, double to) {
    return kTick_s * share * (from + 0.5 * share * (to - from));
  };
  const double way_m = next.stalled ? 0.0 : covered(state.linear_mps, next.linear_mps);
  const double turn_rad = covered(state.angular_radps, next.angular_radps);
  state.pose = moved(state.pose, way_m, -turn_rad);
  state.way_m += way_m;
  state.odometry_x_m += share * (next.odometry_x_m - state.odometry_x_m);
  state.odometry_y_m += share * (next.odometry_y_m - state.odometry_y_m);
  const double counted_rad =
      std::remainder(next.odometry_heading_rad - state.odometry_heading_rad, 2.0 * M_PI);
  state.odometry_heading_rad += share * counted_rad;
  return state;
}

}  // namespace egomod::sim
