// SPDX-License-Identifier: Apache-2.0
#include "duty.hpp"

#include <algorithm>
#include <cmath>

namespace egomod::eval {
namespace {

// Times in files are rounded.
constexpr double kTimeSlack_s = 1e-9;

class DutyRoster {
 public:
  DutyRoster(const Truth& truth, const DetectionOptions& options)
      : truth_(truth), options_(options), rate_hz_(counted_rate_hz(truth, options)) {}

  Duty next(const TruthObject& object) {
    if (object.moving) moved_s_[object.id] = object.time_s;
    if (qualifies(object)) {
      const double since_s = since_s_.try_emplace(object.id, object.time_s).first->second;
      return object.time_s - since_s >= options_.grace_s - kTimeSlack_s ? Duty::kDue : Duty::kGrace;
    }
    since_s_.erase(object.id);
    return !object.moving && rests(object) ? Duty::kStill : Duty::kOther;
  }

 private:
  [[nodiscard]] bool qualifies(const TruthObject& object) const {
    if (!object.moving || object.visible_px < options_.min_px ||
        object.surface_m.z() > options_.max_depth_m) {
      return false;
    }
    return options_.v90_factor == 0.0 ||
           object.velocity_mps.norm() >=
               options_.v90_factor * v90_mps(object, rate_hz_, truth_.focal_px, truth_.baseline_m);
  }

  [[nodiscard]] bool rests(const TruthObject& object) const {
    const auto moved = moved_s_.find(object.id);
    return moved == moved_s_.end() || object.time_s - moved->second > options_.grace_s;
  }

  const Truth& truth_;
  const DetectionOptions& options_;
  double rate_hz_;
  std::map<std::string, double> since_s_;  // qualifies without a break
  std::map<std::string, double> moved_s_;  // last seen moving
};

}  // namespace

double v90_mps(const TruthObject& object, double rate_hz, double focal_px, double baseline_m) {
  constexpr double kSigmaDisparity_px = 0.25;
  constexpr double kFloor_mps = 0.05;
  constexpr double kPower = 2.5;
  const double n = std::max(2.0, std::nearbyint(rate_hz));
  // Slope of a straight line through n points: its standard deviation for unit noise, per second.
  const double k = std::sqrt(12.0 / (n * (n * n - 1.0))) * rate_hz;
  const double z_m = object.surface_m.z();
  const double speed_mps = object.velocity_mps.norm();
  const double axial = speed_mps > 0.0 ? std::abs(object.velocity_mps.z()) / speed_mps : 1.0;
  const double sigma_axial_m = z_m * z_m * kSigmaDisparity_px / (focal_px * baseline_m);
  const double sigma_lateral_m = z_m * kSigmaDisparity_px / std::sqrt(2.0) / focal_px;
  const double variance_m2 = axial * axial * sigma_axial_m * sigma_axial_m +
                             (1.0 - axial * axial) * sigma_lateral_m * sigma_lateral_m;
  return std::hypot(kFloor_mps, kPower * k * std::sqrt(variance_m2));
}

std::vector<int> counted_frames(int frames, const DetectionOptions& options) {
  std::vector<int> counted;
  for (int frame = options.first_frame; frame < frames; ++frame) {
    if (frame % options.every != 0) continue;
    if (!options.only || std::binary_search(options.only->begin(), options.only->end(), frame))
      counted.push_back(frame);
  }
  return counted;
}

double counted_rate_hz(const Truth& truth, const DetectionOptions& options) {
  if (!options.only) return truth.rate_hz() / options.every;
  const std::vector<int> counted = counted_frames(truth.frames(), options);
  if (counted.size() < 2) return truth.rate_hz();
  const auto time_s = [&](int frame) { return truth.times_s[static_cast<std::size_t>(frame)]; };
  return static_cast<double>(counted.size() - 1) /
         (time_s(counted.back()) - time_s(counted.front()));
}

std::map<int, std::vector<Duty>> duties(const Truth& truth, const std::vector<int>& counted,
                                        const DetectionOptions& options) {
  DutyRoster roster(truth, options);
  std::map<int, std::vector<Duty>> all;
  for (const int frame : counted) {
    const auto objects = truth.objects->find(frame);
    if (objects == truth.objects->end()) continue;
    for (const TruthObject& object : objects->second) all[frame].push_back(roster.next(object));
  }
  return all;
}

}  // namespace egomod::eval
