// SPDX-License-Identifier: Apache-2.0
#include "noise.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "pixel_truth.hpp"

namespace egomod::eval {
namespace {

constexpr double kToSigma = 1.4826;  // from the median of |x|, x ~ N(0, 1)
constexpr std::size_t kLeastSights = 5;
constexpr std::size_t kLeastErrors = 100;

struct Errors {
  double depth_m = 0.0;
  double u_px = 0.0, v_px = 0.0, disparity_px = 0.0;
};

// A track's errors since its first sight.
struct Sights {
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();  // in the world, where it was first seen
  std::vector<Errors> errors;
};

struct Samples {
  std::vector<double> pixel_px, disparity_px;
};

double sigma_of(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return kToSigma * *middle;
}

NoisePair sigmas(const Samples& samples) {
  return {sigma_of(samples.pixel_px), sigma_of(samples.disparity_px)};
}

class TrueErrors {
 public:
  TrueErrors(const Truth& truth, PixelTruth pixels) : truth_(truth), pixels_(std::move(pixels)) {
    for (const NumberedPose& pose : truth.poses) poses_[pose.frame] = pose.T_world_camera;
  }

  void add(const PointEvidence& point) {
    const auto pose = poses_.find(point.frame);
    const auto depth_m = pixels_.resting_depth_at(point.frame, point.u_px, point.v_px);
    if (pose == poses_.end() || !depth_m) return;
    const auto [entry, is_first] = tracks_.try_emplace(point.track);
    const double f_px = truth_.focal_px;
    if (is_first) {
      entry->second.place_m =
          pose->second * Eigen::Vector3d{(point.u_px - truth_.cx_px) / f_px * *depth_m,
                                         (point.v_px - truth_.cy_px) / f_px * *depth_m, *depth_m};
      return;
    }
    const Eigen::Vector3d P_m = pose->second.inverse() * entry->second.place_m;
    if (!(P_m.z() > 0.0)) return;
    entry->second.errors.push_back(
        {.depth_m = *depth_m,
         .u_px = point.u_px - truth_.cx_px - f_px * P_m.x() / P_m.z(),
         .v_px = point.v_px - truth_.cy_px - f_px * P_m.y() / P_m.z(),
         .disparity_px = point.disparity_px - f_px * truth_.baseline_m / *depth_m});
  }

  // Errors at these depths; `varying`: without the mean of each track's.
  [[nodiscard]] Samples samples(double from_m, double to_m, bool varying) const {
    Samples samples;
    for (const auto& [id, track] : tracks_) {
      if (track.errors.size() < kLeastSights) continue;
      const Errors mean = varying ? mean_of(track.errors) : Errors{};
      for (const Errors& e : track.errors) {
        if (e.depth_m < from_m || (to_m > 0.0 && e.depth_m >= to_m)) continue;
        samples.pixel_px.push_back(e.u_px - mean.u_px);
        samples.pixel_px.push_back(e.v_px - mean.v_px);
        samples.disparity_px.push_back(e.disparity_px - mean.disparity_px);
      }
    }
    return samples;
  }

 private:
  static Errors mean_of(const std::vector<Errors>& errors) {
    Errors mean;
    const double share = 1.0 / static_cast<double>(errors.size());
    for (const Errors& e : errors) {
      mean.u_px += share * e.u_px;
      mean.v_px += share * e.v_px;
      mean.disparity_px += share * e.disparity_px;
    }
    return mean;
  }

  const Truth& truth_;
  PixelTruth pixels_;
  std::map<int, Eigen::Isometry3d> poses_;
  std::map<std::int64_t, Sights> tracks_;
};

}  // namespace

std::vector<NoiseFigures> score_noise(const Truth& truth, const Record& record, int first_frame) {
  std::vector<NoiseFigures> figures;
  std::optional<PixelTruth> pixels = PixelTruth::open(truth.folder);
  if (!pixels || !record.points || truth.poses.empty() || !(truth.focal_px > 0.0)) return figures;
  TrueErrors errors(truth, std::move(*pixels));
  for (const PointEvidence& point : *record.points) {
    if (point.frame >= first_frame && point.frame < truth.frames()) errors.add(point);
  }
  for (const auto& [range, learnt] : record.noise) {
    const Samples whole = errors.samples(range.first, range.second, false);
    if (whole.disparity_px.size() < kLeastErrors || !(learnt.weight > 0.0)) continue;
    figures.push_back({.from_m = range.first,
                       .to_m = range.second,
                       .learnt = {std::sqrt(learnt.pixel_px2 / learnt.weight),
                                  std::sqrt(learnt.disparity_px2 / learnt.weight)},
                       .whole = sigmas(whole),
                       .varying = sigmas(errors.samples(range.first, range.second, true)),
                       .observations = static_cast<int>(whole.disparity_px.size())});
  }
  return figures;
}

}  // namespace egomod::eval
