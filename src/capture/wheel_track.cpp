// SPDX-License-Identifier: Apache-2.0
#include "capture/wheel_track.hpp"

#include <chrono>
#include <cmath>
#include <egomod/odometry_t.hpp>
#include <numbers>

#include "capture/image_message.hpp"

namespace egomod {
namespace {

constexpr Nanoseconds kClockStep = std::chrono::seconds(1);
// No base drives like this: one that seems to has been set to another pose.
constexpr double kJump_mps = 30.0;
constexpr double kJump_m = 0.5;

// In the first one's frame.
struct PlaneMotion {
  double x_m;
  double y_m;
  double turn_rad;
};

PlaneMotion motion_between(const WheelReading& a, const WheelReading& b) {
  const double x_m = b.x_m - a.x_m;
  const double y_m = b.y_m - a.y_m;
  const double c = std::cos(a.heading_rad);
  const double s = std::sin(a.heading_rad);
  return {c * x_m + s * y_m, -s * x_m + c * y_m,
          std::remainder(b.heading_rad - a.heading_rad, 2.0 * std::numbers::pi)};
}

// Shares of an arc: the chord's way in the plane's exponential, V(turn)^-1 and V(share * turn).
PlaneMotion part_of(const PlaneMotion& whole, double share) {
  const double half = 0.5 * whole.turn_rad;
  const double cot = std::abs(half) < 1e-6 ? 1.0 : half / std::tan(half);
  const double vx = cot * whole.x_m + half * whole.y_m;
  const double vy = -half * whole.x_m + cot * whole.y_m;
  const double turn = share * whole.turn_rad;
  const double sine = std::abs(turn) < 1e-6 ? 1.0 : std::sin(turn) / turn;
  const double versine = std::abs(turn) < 1e-6 ? 0.5 * turn : (1.0 - std::cos(turn)) / turn;
  return {share * (sine * vx - versine * vy), share * (versine * vx + sine * vy), turn};
}

Eigen::Isometry3d pose_after(const WheelReading& from, const PlaneMotion& motion) {
  const auto turned = [](double heading_rad) {
    return Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ());
  };
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = turned(from.heading_rad + motion.turn_rad).toRotationMatrix();
  T.translation() = Eigen::Vector3d(from.x_m, from.y_m, 0.0) +
                    turned(from.heading_rad) * Eigen::Vector3d(motion.x_m, motion.y_m, 0.0);
  return T;
}

}  // namespace

std::optional<WheelReading> decode_odometry(std::span<const std::uint8_t> message) {
  odometry_t odometry{};
  if (odometry.decode(message.data(), 0, static_cast<int>(message.size())) < 0) return std::nullopt;
  const bool is_sound = std::isfinite(odometry.x) && std::isfinite(odometry.y) &&
                        std::isfinite(odometry.heading) && odometry.utime >= -kMaxUtime_us &&
                        odometry.utime <= kMaxUtime_us;
  if (!is_sound) return std::nullopt;
  return WheelReading{.time = std::chrono::microseconds(odometry.utime),
                      .sequence = odometry.sequence,
                      .x_m = odometry.x,
                      .y_m = odometry.y,
                      .heading_rad = odometry.heading};
}

WheelTrack::WheelTrack(double max_age_s)
    : max_age_(static_cast<std::int64_t>(1e9 * max_age_s)), readings_(kCapacity) {}

bool WheelTrack::breaks_off(const WheelReading& next) const {
  const double dt_s = to_seconds(next.time - last().time);
  const double way_m = std::hypot(next.x_m - last().x_m, next.y_m - last().y_m);
  return next.sequence < last().sequence || dt_s < 0.0 || way_m > kJump_m + kJump_mps * dt_s;
}

void WheelTrack::add(const WheelReading& reading) {
  if (count_ > 0) {
    const bool steps_back = reading.time < last().time - kClockStep;
    if (reading.time <= last().time && !steps_back) return;
    if (breaks_off(reading)) {
      ++stretch_;
      count_ = 0;
    }
  }
  if (count_ == kCapacity) {
    first_ = (first_ + 1) % kCapacity;
    --count_;
  }
  readings_[(first_ + count_) % kCapacity] = reading;
  ++count_;
}

std::optional<WheelPose> WheelTrack::at(Nanoseconds exposure) const {
  std::size_t after = count_;  // the first reading that is later
  while (after > 0 && reading(after - 1).time > exposure) --after;
  if (after == 0) return std::nullopt;
  const WheelReading& before = reading(after - 1);
  if (before.time == exposure) return WheelPose{pose_after(before, {}), stretch_};
  const bool is_between = after < count_;
  if (!is_between && (count_ < 2 || exposure - before.time > max_age_)) return std::nullopt;
  const WheelReading& from = is_between ? before : reading(after - 2);
  const WheelReading& to = is_between ? reading(after) : before;
  if (to.time - from.time > max_age_) return std::nullopt;
  const double share = to_seconds(exposure - before.time) / to_seconds(to.time - from.time);
  return WheelPose{pose_after(before, part_of(motion_between(from, to), share)), stretch_};
}

std::vector<std::optional<WheelPose>> wheel_poses(std::span<const WheelReading> readings,
                                                  std::span<const Nanoseconds> exposures,
                                                  double max_age_s) {
  WheelTrack track(max_age_s);
  std::vector<std::optional<WheelPose>> poses;
  poses.reserve(exposures.size());
  auto next = readings.begin();
  for (const Nanoseconds exposure : exposures) {
    while (next != readings.end() && !track.reaches(exposure)) track.add(*next++);
    poses.push_back(track.at(exposure));
  }
  return poses;
}

}  // namespace egomod
