// SPDX-License-Identifier: Apache-2.0
// Developer program: features and egomotion on every n-th pair of a folder, poses to a file of
// KITTI rows, each behind its pair's number.
//   odometry_on_folder DIR POSES [gauss_newton|ispkf] [map|pairs] [EVERY]
#include <chrono>
#include <cstdio>
#include <fstream>
#include <limits>
#include <string>

#include "egomod/capture/frame_source.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomod/features/feature_tracker.hpp"

namespace egomod {
namespace {

struct Totals {
  double features_ms = 0.0;
  double egomotion_ms = 0.0;
  double inliers = 0.0;
  double residual_px = 0.0;
  int valid = 0;
  int failed = 0;
};

template <typename Work>
double milliseconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

void write_pose(std::ofstream& file, std::uint64_t sequence, const Eigen::Isometry3d& T) {
  file.precision(std::numeric_limits<double>::max_digits10);
  file << sequence << ' ';
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) file << T.matrix()(r, c) << (r == 2 && c == 3 ? '\n' : ' ');
}

void run(const std::string& folder, const std::string& poses, const EgomotionConfig& config,
         std::uint64_t every) {
  const auto source = open_source("folder:" + folder, CaptureConfig{}, "", "");
  FeatureTracker tracker{FeaturesConfig{}};
  EgomotionEstimator estimator{config};
  StereoPair pair;
  TrackSet tracks;
  Egomotion motion;
  Totals totals;
  std::ofstream file(poses);
  while (source->next(pair, {}) == SourceState::kPair) {
    if (pair.sequence % every != 0) pair.status = PairStatus::kSkipped;
    totals.features_ms += milliseconds([&] { tracker.track(pair, tracks); });
    totals.egomotion_ms += milliseconds([&] { estimator.estimate(tracks, motion); });
    if (motion.status != EstimateStatus::kSkipped)
      write_pose(file, pair.sequence, motion.T_first_current);
    totals.failed += motion.status == EstimateStatus::kFailed ? 1 : 0;
    if (motion.status != EstimateStatus::kValid) continue;
    ++totals.valid;
    totals.inliers += motion.inliers;
    totals.residual_px += motion.residual_px;
  }
  std::printf(
      "valid %d failed %d; mean inliers %.0f, residual %.3f px; features %.2f ms, "
      "egomotion %.2f ms a valid pair\n",
      totals.valid, totals.failed, totals.inliers / totals.valid, totals.residual_px / totals.valid,
      totals.features_ms / totals.valid, totals.egomotion_ms / totals.valid);
}

}  // namespace
}  // namespace egomod

int main(int argc, char** argv) {
  using namespace egomod;
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s DIR POSES [gauss_newton|ispkf] [map|pairs] [EVERY]\n", argv[0]);
    return 2;
  }
  EgomotionConfig config;
  if (argc > 3 && std::string(argv[3]) == "ispkf")
    config.method = EgomotionMethod::kSigmaPointKalmanFilter;
  if (argc > 4) config.map = std::string(argv[4]) == "map";
  try {
    run(argv[1], argv[2], config, argc > 5 ? std::stoul(argv[5]) : 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
