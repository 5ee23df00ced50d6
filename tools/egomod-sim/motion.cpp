// SPDX-License-Identifier: Apache-2.0
#include "motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace egomod::sim {
namespace {

// Distance at unit speed while going for go_s, speed a trapezoid with ramps at both ends.
double trapezoid(double t_s, double go_s, double ramp_s) {
  const double t = std::clamp(t_s, 0.0, go_s);
  const double ramp = std::min(ramp_s, 0.5 * go_s);
  if (ramp <= 0.0) return t;
  if (t < ramp) return 0.5 * t * t / ramp;
  if (t <= go_s - ramp) return t - 0.5 * ramp;
  const double left = go_s - t;
  return go_s - ramp - 0.5 * left * left / ramp;
}

double with_stops(const SpeedProfile& p, double t_s) {
  if (p.pause_s <= 0.0) return trapezoid(t_s, p.go_s, p.ramp_s);
  const double period_s = p.go_s + p.pause_s;
  const double cycles = std::floor(t_s / period_s);
  return cycles * trapezoid(p.go_s, p.go_s, p.ramp_s) +
         trapezoid(t_s - cycles * period_s, p.go_s, p.ramp_s);
}

double accelerated(const SpeedProfile& p, double t_s) {
  const bool brakes = p.acceleration_mps2 < 0.0;
  const double t = brakes ? std::min(t_s, -p.speed_mps / p.acceleration_mps2) : t_s;
  return p.speed_mps * t + 0.5 * p.acceleration_mps2 * t * t;
}

Eigen::Vector2d direction(double heading_rad) {
  return {std::sin(heading_rad), std::cos(heading_rad)};
}

PlanPose advanced(const PathPiece& piece, double s_m) {
  const auto& [x, z, heading] = piece.start;
  const double k = piece.curvature_pm;
  if (std::abs(k) < 1e-9) {
    return {x + s_m * std::sin(heading), z + s_m * std::cos(heading), heading};
  }
  const double end = heading + k * s_m;
  return {x + (std::cos(heading) - std::cos(end)) / k, z + (std::sin(end) - std::sin(heading)) / k,
          end};
}

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * M_PI); }

}  // namespace

double distance_m(const SpeedProfile& p, double t_s) {
  const double t = t_s - p.start_s;
  if (p.go_s > 0.0) return t <= 0.0 ? 0.0 : p.speed_mps * with_stops(p, t);
  if (p.start_s <= 0.0) return accelerated(p, t);
  if (t <= 0.0) return 0.0;
  const double ramp = std::max(p.ramp_s, 1e-9);
  if (t < ramp) return 0.5 * p.speed_mps * t * t / ramp;
  return 0.5 * p.speed_mps * ramp + accelerated(p, t - ramp);
}

Path endless_path(const PlanPose& start, double curvature_pm) {
  return {{start, std::numeric_limits<double>::infinity(), curvature_pm}};
}

Path rounded_path(const std::vector<Eigen::Vector2d>& points_m, double radius_m) {
  Path path;
  Eigen::Vector2d from = points_m.front();
  for (std::size_t i = 1; i < points_m.size(); ++i) {
    const Eigen::Vector2d leg = points_m[i] - from;
    const double heading = std::atan2(leg.x(), leg.y());
    if (i + 1 == points_m.size()) {
      path.push_back({{from.x(), from.y(), heading}, leg.norm(), 0.0});
      break;
    }
    const Eigen::Vector2d next = points_m[i + 1] - points_m[i];
    const double turn = wrapped(std::atan2(next.x(), next.y()) - heading);
    // The tangent from the corner to where the arc begins; half a leg is left to its other end.
    const double tangent_m = std::tan(0.5 * std::abs(turn));
    const double cut_m = std::min({radius_m * tangent_m, leg.norm(), 0.5 * next.norm()});
    const Eigen::Vector2d entry = points_m[i] - cut_m * direction(heading);
    path.push_back({{from.x(), from.y(), heading}, (entry - from).norm(), 0.0});
    from = points_m[i];
    if (cut_m < 1e-9) continue;
    const double fitted_m = cut_m / tangent_m;
    path.push_back({{entry.x(), entry.y(), heading},
                    fitted_m * std::abs(turn),
                    std::copysign(1.0 / fitted_m, turn)});
    from += cut_m * direction(heading + turn);
  }
  return path;
}

PlanPose pose_at(const Path& path, double along_m) {
  double left_m = along_m;
  for (const PathPiece& piece : path) {
    if (left_m <= piece.length_m) return advanced(piece, left_m);
    left_m -= piece.length_m;
  }
  return advanced(path.back(), path.back().length_m);
}

PlanPose pose_at(const Motion& motion, double t_s) {
  PlanPose pose = pose_at(motion.path, way_m(motion, t_s));
  pose.heading_rad += motion.facing_rad + motion.spin_radps * distance_m(motion.profile, t_s);
  return pose;
}

double way_m(const Motion& motion, double t_s) {
  if (motion.spin_radps != 0.0) return 0.0;
  double length_m = 0.0;
  for (const PathPiece& piece : motion.path) length_m += piece.length_m;
  return std::min(distance_m(motion.profile, t_s), length_m);
}

}  // namespace egomod::sim
