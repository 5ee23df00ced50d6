// SPDX-License-Identifier: Apache-2.0
#include "cases.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "tables.hpp"

namespace egomod::thesis {
namespace {

namespace fs = std::filesystem;

void require(const fs::path& path) {
  if (!fs::exists(path)) {
    throw eval::InputError(path.string() +
                           ": is not there; tools/reproduce-thesis renders the cases and records "
                           "both methods");
  }
}

// The target counts wherever a pixel of it shows: these are pictures of one thing, not a score.
eval::DetectionOptions whatever_shows() {
  return {.min_px = 1,
          .max_depth_m = std::numeric_limits<double>::max(),
          .grace_s = 0.0,
          .v90_factor = 0.0};
}

eval::Evaluation evaluation_of(const fs::path& folder, const std::string& method,
                               bool processed_only) {
  require(folder / "truth");
  const fs::path record = folder / (method + ".lcmlog");
  require(record);
  return eval::evaluate({.name = "",
                         .truth = folder / "truth",
                         .estimate = record,
                         .kind = eval::EstimateKind::kRecord,
                         .method = method,
                         .processed_only = processed_only},
                        whatever_shows());
}

void require_target(const eval::Truth& truth) {
  if (!truth.objects || truth.poses.empty()) {
    throw eval::InputError(truth.folder.string() + ": needs poses.txt and objects.csv");
  }
  if (true_sightings(truth).empty()) {
    throw eval::InputError(truth.folder.string() + ": shows no moving target");
  }
}

const Eigen::Isometry3d& pose_at(const eval::Poses& poses, int frame) {
  const auto at =
      std::lower_bound(poses.begin(), poses.end(), frame,
                       [](const eval::NumberedPose& pose, int f) { return pose.frame < f; });
  if (at == poses.end() || at->frame != frame) {
    throw eval::InputError("no pose of frame " + std::to_string(frame) +
                           ", though an object was reported there");
  }
  return at->T_world_camera;
}

Sighting sighting(int frame, double time_s, const Eigen::Vector3d& position_m,
                  const Eigen::Vector3d& velocity_mps, const eval::Rectangle& rectangle,
                  const eval::Truth& truth, const Eigen::Isometry3d& T_first_camera) {
  const auto side_m = [&](double u_px) {
    const double x_m = (u_px - truth.cx_px) / truth.focal_px * position_m.z();
    return (T_first_camera * Eigen::Vector3d(x_m, position_m.y(), position_m.z())).x();
  };
  Sighting s;
  s.frame = frame;
  s.time_s = time_s;
  s.depth_m = position_m.z();
  s.position_m = T_first_camera * position_m;
  s.velocity_mps = T_first_camera.linear() * velocity_mps;
  s.left_m = side_m(rectangle.u_min_px);
  s.right_m = side_m(rectangle.u_max_px);
  return s;
}

}  // namespace

Case read_case(const std::string& folder) {
  Case one{.folder = folder,
           .thesis = evaluation_of(folder, "thesis", true),
           .standard = evaluation_of(folder, "default", false)};
  require_target(one.standard.truth);
  return one;
}

eval::Evaluation read_thesis_run(const std::string& folder, const std::string& record) {
  eval::Evaluation run = evaluation_of(folder, record, true);
  require_target(run.truth);
  return run;
}

std::vector<Sighting> true_sightings(const eval::Truth& truth) {
  std::vector<Sighting> all;
  for (const auto& [frame, objects] : *truth.objects) {
    for (const eval::TruthObject& object : objects) {
      if (!object.moving || object.visible_px <= 0) continue;
      all.push_back(sighting(frame, object.time_s, object.surface_m, object.velocity_mps,
                             object.rectangle, truth, pose_at(truth.poses, frame)));
    }
  }
  return all;
}

std::vector<Sighting> sightings(const eval::Evaluation& evaluation) {
  std::vector<Sighting> all;
  for (const eval::Match& m : evaluation.detection->matches) {
    all.push_back(sighting(m.frame, m.truth.time_s, m.estimate.position_m, m.estimate.velocity_mps,
                           m.estimate.rectangle, evaluation.truth,
                           pose_at(evaluation.estimate.poses, m.frame)));
    all.back().depth_m = m.truth.surface_m.z();
    const Eigen::Vector3d error_m = m.estimate.position_m - m.truth.surface_m;
    all.back().position_error_m = error_m.norm();
    all.back().right_error_m = error_m.x();
    all.back().up_error_m = -error_m.y();
    all.back().ahead_error_m = error_m.z();
    all.back().velocity_error_mps = (m.estimate.velocity_mps - m.truth.velocity_mps).norm();
  }
  return all;
}

std::vector<RigSpeed> rig_speeds(const eval::Poses& poses, const std::vector<double>& times_s) {
  std::vector<RigSpeed> speeds;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const auto frame = static_cast<std::size_t>(poses[i].frame);
    if (frame >= times_s.size()) break;
    const double time_s = times_s[frame];
    const double dt_s = time_s - times_s[static_cast<std::size_t>(poses[i - 1].frame)];
    const Eigen::Isometry3d T_previous_current =
        poses[i - 1].T_world_camera.inverse() * poses[i].T_world_camera;
    speeds.push_back({time_s, T_previous_current.translation().z() / dt_s});
  }
  return speeds;
}

}  // namespace egomod::thesis
