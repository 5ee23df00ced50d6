// SPDX-License-Identifier: Apache-2.0
#include "consistency.hpp"

#include <Eigen/Cholesky>

#include "egomod/core/geometry.hpp"

namespace egomod::eval {
namespace {

constexpr double kWindow_s = 1.0;
constexpr double kTimeSlack_s = 1e-6;

// Nothing where the covariance is not one.
template <int N>
std::optional<double> nees(const Eigen::Matrix<double, N, 1>& error,
                           const Eigen::Matrix<double, N, N>& covariance) {
  if (!covariance.allFinite() || !error.allFinite()) return std::nullopt;
  const Eigen::LLT<Eigen::Matrix<double, N, N>> llt(covariance);
  if (llt.info() != Eigen::Success) return std::nullopt;
  return error.dot(llt.solve(error));
}

void keep(const std::optional<double>& value, std::vector<double>& values) {
  if (value) values.push_back(*value);
}

// Poses of consecutive pairs between resets, with what is true of each.
struct Stretch {
  std::vector<const PoseEvidence*> poses;
  std::vector<Eigen::Isometry3d> truth;
  std::vector<double> times_s;

  // Of the motion from i to j, as T_true = T_estimated Exp(xi).
  [[nodiscard]] Vector6d error(std::size_t i, std::size_t j) const {
    const Eigen::Isometry3d estimate =
        poses[i]->T_first_camera.inverse() * poses[j]->T_first_camera;
    return se3_log(estimate.inverse() * (truth[i].inverse() * truth[j]));
  }
  // Takes a perturbation at i to the one at j that it amounts to.
  [[nodiscard]] Matrix6d carry(std::size_t i, std::size_t j) const {
    return adjoint(poses[j]->T_first_camera.inverse() * poses[i]->T_first_camera);
  }
};

std::vector<Stretch> stretches(const Truth& truth, const std::vector<PoseEvidence>& evidence) {
  std::map<int, const Eigen::Isometry3d*> truth_at;
  for (const NumberedPose& pose : truth.poses) truth_at[pose.frame] = &pose.T_world_camera;
  std::vector<Stretch> all;
  for (const PoseEvidence& pose : evidence) {
    const auto at = truth_at.find(pose.frame);
    if (at == truth_at.end() || pose.frame >= truth.frames()) continue;
    if (all.empty() || all.back().poses.back()->reset_count != pose.reset_count) all.emplace_back();
    Stretch& stretch = all.back();
    stretch.poses.push_back(&pose);
    stretch.truth.push_back(*at->second);
    stretch.times_s.push_back(truth.times_s[static_cast<std::size_t>(pose.frame)]);
  }
  return all;
}

struct MotionSamples {
  std::vector<double> pair, second_by_pose, second_by_pairs, pose;
};

void add_second(const Stretch& s, std::size_t i, MotionSamples& samples) {
  std::size_t j = i;
  bool composed = true;
  Matrix6d by_pairs = Matrix6d::Zero();
  while (j < s.poses.size() && s.times_s[j] < s.times_s[i] + kWindow_s - kTimeSlack_s) {
    if (++j == s.poses.size()) return;
    const Matrix6d A = s.carry(j - 1, j);
    by_pairs = A * by_pairs * A.transpose();
    composed = composed && s.poses[j]->motion_covariance.has_value();
    if (composed) by_pairs += *s.poses[j]->motion_covariance;
  }
  if (!s.poses[i]->estimated || !s.poses[j]->estimated) return;
  const Matrix6d A = s.carry(i, j);
  const Vector6d error = s.error(i, j);
  keep(nees<6>(error, s.poses[j]->covariance - A * s.poses[i]->covariance * A.transpose()),
       samples.second_by_pose);
  if (composed) keep(nees<6>(error, by_pairs), samples.second_by_pairs);
}

void add_stretch(const Stretch& s, MotionSamples& samples) {
  for (std::size_t i = 0; i < s.poses.size(); ++i) {
    add_second(s, i, samples);
    if (i == 0 || !s.poses[i]->estimated) continue;
    keep(nees<6>(s.error(0, i), s.poses[i]->covariance), samples.pose);
    if (s.poses[i]->motion_covariance && s.poses[i - 1]->estimated &&
        s.poses[i]->frame == s.poses[i - 1]->frame + 1) {
      keep(nees<6>(s.error(i - 1, i), *s.poses[i]->motion_covariance), samples.pair);
    }
  }
}

}  // namespace

ConsistencyFigures score_consistency(const Truth& truth, const std::vector<PoseEvidence>& evidence,
                                     const std::vector<Match>& matches) {
  MotionSamples motion;
  for (const Stretch& stretch : stretches(truth, evidence)) add_stretch(stretch, motion);
  std::vector<double> velocity;
  std::vector<double> position;
  for (const Match& m : matches) {
    const Detection& e = m.estimate;
    if (e.velocity_covariance_m2ps2) {
      keep(nees<3>(e.velocity_mps - m.truth.velocity_mps, *e.velocity_covariance_m2ps2), velocity);
    }
    if (e.position_covariance_m2) {
      keep(nees<3>(e.position_m - m.truth.surface_m, *e.position_covariance_m2), position);
    }
  }
  return {.pair = consistency(motion.pair, 6),
          .second_by_pose = consistency(motion.second_by_pose, 6),
          .second_by_pairs = consistency(motion.second_by_pairs, 6),
          .pose = consistency(motion.pose, 6),
          .object_velocity = consistency(velocity, 3),
          .object_position = consistency(position, 3)};
}

}  // namespace egomod::eval
