// SPDX-License-Identifier: Apache-2.0
#include "odometry.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace egomod::eval {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kKittiPath_m = 800.0;
constexpr double kShortestPath_m = 0.5;
constexpr double kShortestSegment_m = 0.25;

using Isometries = std::vector<Eigen::Isometry3d>;

Eigen::Isometry3d between(const Isometries& T, std::size_t from, std::size_t to) {
  return T[from].inverse() * T[to];
}

std::vector<double> path_lengths(const Isometries& T) {
  std::vector<double> lengths_m{0.0};
  for (std::size_t i = 1; i < T.size(); ++i)
    lengths_m.push_back(lengths_m.back() + (T[i].translation() - T[i - 1].translation()).norm());
  return lengths_m;
}

void score_pairs(const AlignedPoses& poses, OdometryFigures& figures) {
  std::vector<double> mm;
  std::vector<double> mdeg;
  for (std::size_t i = 1; i < poses.frames.size(); ++i) {
    const Eigen::Isometry3d motion = between(poses.truth, i - 1, i);
    figures.turn_deg += angle_deg(motion);
    if (poses.frames[i] != poses.frames[i - 1] + 1) continue;
    const Eigen::Isometry3d error = motion.inverse() * between(poses.estimate, i - 1, i);
    mm.push_back(1e3 * error.translation().norm());
    mdeg.push_back(1e3 * angle_deg(error));
  }
  figures.pair_mm = summarise(mm);
  figures.pair_mdeg = summarise(mdeg);
}

// The rigid motion that takes the estimated positions to the true ones, least squares (Umeyama,
// PAMI 1991, eqs. 38-43 without scale).
Eigen::Isometry3d best_alignment(const AlignedPoses& poses) {
  Eigen::Vector3d mean_estimate = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_truth = Eigen::Vector3d::Zero();
  const auto count = static_cast<double>(poses.truth.size());
  for (std::size_t i = 0; i < poses.truth.size(); ++i) {
    mean_estimate += poses.estimate[i].translation() / count;
    mean_truth += poses.truth[i].translation() / count;
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < poses.truth.size(); ++i) {
    covariance += (poses.truth[i].translation() - mean_truth) *
                  (poses.estimate[i].translation() - mean_estimate).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1.0, 1.0, 1.0);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs.z() = -1.0;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  T.translation() = mean_truth - T.linear() * mean_estimate;
  return T;
}

void score_positions(const AlignedPoses& poses, OdometryFigures& figures) {
  const Eigen::Isometry3d T = best_alignment(poses);
  double first_squares = 0.0;
  double rigid_squares = 0.0;
  for (std::size_t i = 0; i < poses.truth.size(); ++i) {
    const Eigen::Vector3d truth = poses.truth[i].translation();
    const Eigen::Vector3d estimate = poses.estimate[i].translation();
    figures.end_error_m = (estimate - truth).norm();
    figures.max_error_m = std::max(figures.max_error_m, figures.end_error_m);
    first_squares += (estimate - truth).squaredNorm();
    rigid_squares += (T * estimate - truth).squaredNorm();
  }
  const auto count = static_cast<double>(poses.truth.size());
  figures.first_aligned_rmse_m = std::sqrt(first_squares / count);
  figures.rigid_aligned_rmse_m = std::sqrt(rigid_squares / count);
  figures.end_rotation_deg = angle_deg(poses.truth.back().inverse() * poses.estimate.back());
}

std::vector<double> segment_lengths(double path_m) {
  std::vector<double> lengths_m;
  for (int k = 1; k <= 8 && path_m >= kKittiPath_m; ++k) lengths_m.push_back(100.0 * k);
  for (int k = 2; k <= 8 && path_m < kKittiPath_m; ++k) {
    if (path_m * k / 10 >= kShortestSegment_m) lengths_m.push_back(path_m * k / 10);
  }
  return lengths_m;
}

struct Errors {
  std::vector<double> translation;  // per metre
  std::vector<double> rotation_deg_per_m;
};

Errors segment_errors(const AlignedPoses& poses, const std::vector<double>& path_m,
                      double length_m) {
  Errors errors;
  for (std::size_t i = 0; i < path_m.size(); ++i) {
    const auto end = std::lower_bound(path_m.begin(), path_m.end(), path_m[i] + length_m);
    if (end == path_m.end()) break;
    const auto j = static_cast<std::size_t>(end - path_m.begin());
    const Eigen::Isometry3d error =
        between(poses.truth, i, j).inverse() * between(poses.estimate, i, j);
    errors.translation.push_back(error.translation().norm() / (*end - path_m[i]));
    errors.rotation_deg_per_m.push_back(angle_deg(error) / (*end - path_m[i]));
  }
  return errors;
}

std::optional<RelativeDrift> relative_drift(const AlignedPoses& poses,
                                            const std::vector<double>& path_m) {
  RelativeDrift drift;
  Errors all;
  for (const double length_m : segment_lengths(path_m.back())) {
    const Errors errors = segment_errors(poses, path_m, length_m);
    if (errors.translation.empty()) continue;
    drift.per_length.push_back({length_m, static_cast<int>(errors.translation.size()),
                                100.0 * summarise(errors.translation)->mean,
                                summarise(errors.rotation_deg_per_m)->mean});
    all.translation.insert(all.translation.end(), errors.translation.begin(),
                           errors.translation.end());
    all.rotation_deg_per_m.insert(all.rotation_deg_per_m.end(), errors.rotation_deg_per_m.begin(),
                                  errors.rotation_deg_per_m.end());
  }
  if (all.translation.empty()) return std::nullopt;
  drift.translation_percent = 100.0 * summarise(all.translation)->mean;
  drift.rotation_deg_per_m = summarise(all.rotation_deg_per_m)->mean;
  return drift;
}

}  // namespace

double angle_deg(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d R = T.linear();
  const Eigen::Vector3d twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  return kDegPerRad * std::atan2(0.5 * twice_sine.norm(), 0.5 * (R.trace() - 1.0));
}

AlignedPoses align_first(const Poses& truth, const Poses& estimate) {
  AlignedPoses aligned;
  std::map<int, const Eigen::Isometry3d*> truth_at;
  for (const NumberedPose& pose : truth) truth_at[pose.frame] = &pose.T_world_camera;
  for (const NumberedPose& pose : estimate) {
    const auto at = truth_at.find(pose.frame);
    if (at == truth_at.end()) continue;
    ++aligned.estimates;
    if (!pose.finite()) continue;
    aligned.frames.push_back(pose.frame);
    aligned.truth.push_back(*at->second);
    aligned.estimate.push_back(pose.T_world_camera);
  }
  if (aligned.frames.empty()) return aligned;
  const Eigen::Isometry3d first_truth = aligned.truth.front().inverse();
  const Eigen::Isometry3d first_estimate = aligned.estimate.front().inverse();
  for (Eigen::Isometry3d& T : aligned.truth) T = first_truth * T;
  for (Eigen::Isometry3d& T : aligned.estimate) T = first_estimate * T;
  return aligned;
}

OdometryFigures score_odometry(const Poses& truth, const Poses& estimate) {
  const AlignedPoses poses = align_first(truth, estimate);
  OdometryFigures figures;
  figures.truth_frames = static_cast<int>(truth.size());
  figures.frames = poses.estimates;
  figures.finite = static_cast<std::size_t>(poses.estimates) == poses.frames.size();
  figures.scored = poses.frames.size() >= 2;
  if (!figures.scored) return figures;
  const std::vector<double> path_m = path_lengths(poses.truth);
  figures.path_m = path_m.back();
  score_pairs(poses, figures);
  score_positions(poses, figures);
  if (figures.path_m >= kShortestPath_m) figures.drift = relative_drift(poses, path_m);
  return figures;
}

}  // namespace egomod::eval
