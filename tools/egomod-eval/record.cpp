// SPDX-License-Identifier: Apache-2.0
#include "record.hpp"

#include <egomod/object_list_t.hpp>
#include <egomod/pose_t.hpp>
#include <egomod/timing_t.hpp>
#include <egomod/track_list_t.hpp>
#include <egomod/velocity_t.hpp>

#include "commands.hpp"
#include "egomod/core/geometry.hpp"
#include "egomod/publish/messages.hpp"
#include "log_reader.hpp"
#include "temporary_folder.hpp"

namespace egomod::eval {
namespace {

Matrix6d matrix_of(const double (&rows)[6][6]) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(&rows[0][0]);
}

Eigen::Matrix3d matrix_of(const double (&rows)[3][3]) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&rows[0][0]);
}

// Adds to what an export holds.
class Evidence {
 public:
  Evidence(const std::string& log, Record& record) : log_(log), reader_(log), record_(record) {}

  void run() {
    while (const lcm::LogEvent* event = reader_.next()) add(*event);
    reader_.require_whole();
  }

 private:
  void add(const lcm::LogEvent& event) {
    if (event.channel == "EGOMOD_CALIBRATION") {
      calibration_t message{};
      reader_.decode(event, message);
      calibration_ = calibration_from(message);
      depth_times_disparity_ = message.fx * message.baseline;
    } else if (event.channel == "EGOMOD_POSE") {
      add_pose(event);
    } else if (event.channel == "EGOMOD_VELOCITY") {
      add_velocity(event);
    } else if (event.channel == "EGOMOD_OBJECTS") {
      add_objects(event);
    } else if (event.channel == "EGOMOD_TRACKS") {
      add_tracks(event);
    } else if (event.channel == "EGOMOD_TIMING") {
      add_timing(event);
    }
  }

  void add_pose(const lcm::LogEvent& event) {
    pose_t message{};
    reader_.decode(event, message);
    const Eigen::Isometry3d& T_body_camera = calibration_.T_body_camera;
    const auto& q = message.orientation;
    Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
    T_world_body.linear() =
        Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    T_world_body.translation() = Eigen::Vector3d::Map(message.pos);
    const Matrix6d Ad = adjoint(T_body_camera.inverse());
    PoseEvidence pose;
    pose.frame = static_cast<int>(message.sequence);
    pose.reset_count = message.reset_count;
    pose.estimated = message.status == pose_t::STATUS_VALID ||
                     message.status == pose_t::STATUS_FIRST ||
                     message.status == pose_t::STATUS_AMBIGUOUS;
    pose.T_first_camera = T_body_camera.inverse() * T_world_body * T_body_camera;
    pose.covariance = Ad * matrix_of(message.covariance) * Ad.transpose();
    record_.poses.push_back(pose);
  }

  // Comes after its pair's pose. The published covariance is that of the motion over its duration;
  // over one pair a rotation vector's and Exp's own perturbation differ by nothing that counts.
  void add_velocity(const lcm::LogEvent& event) {
    velocity_t message{};
    reader_.decode(event, message);
    const bool estimated =
        message.status == pose_t::STATUS_VALID || message.status == pose_t::STATUS_AMBIGUOUS;
    if (!estimated || record_.poses.empty() ||
        record_.poses.back().frame != static_cast<int>(message.sequence)) {
      return;
    }
    const double dt_s = static_cast<double>(message.utime - message.previous_utime) * 1e-6;
    const Matrix6d Ad = adjoint(calibration_.T_body_camera.inverse());
    record_.poses.back().motion_covariance =
        dt_s * dt_s * Ad * matrix_of(message.covariance) * Ad.transpose();
  }

  void add_objects(const lcm::LogEvent& event) {
    object_list_t list{};
    reader_.decode(event, list);
    record_.processed.push_back(static_cast<int>(list.sequence));
    const auto rows = record_.estimate.detections->find(static_cast<int>(list.sequence));
    if (rows == record_.estimate.detections->end()) return;
    const Eigen::Matrix3d R = calibration_.T_body_camera.linear().transpose();
    for (const object_t& object : list.objects) {
      for (Detection& row : rows->second) {
        if (row.track != std::to_string(object.id)) continue;
        row.position_covariance_m2 = R * matrix_of(object.body_pos_covariance) * R.transpose();
        row.velocity_covariance_m2ps2 = R * matrix_of(object.body_vel_covariance) * R.transpose();
        row.speed_sigma_mps = object.speed_sigma;
      }
    }
  }

  void add_tracks(const lcm::LogEvent& event) {
    track_list_t list{};
    reader_.decode(event, list);
    if (!record_.points) record_.points.emplace();
    for (const track_t& track : list.tracks) {
      if (track.state == track_t::STATE_UNKNOWN || !(track.disparity > 0.0F)) continue;
      const Eigen::Vector3d velocity_mps =
          Eigen::Map<const Eigen::Vector3f>(track.vel).cast<double>();
      record_.points->push_back({.frame = static_cast<int>(list.sequence),
                                 .u_px = track.u,
                                 .v_px = track.v,
                                 .depth_m = depth_times_disparity_ / track.disparity,
                                 .speed_mps = velocity_mps.norm(),
                                 .moving = track.state == track_t::STATE_MOVING,
                                 .track = track.id,
                                 .disparity_px = track.disparity});
    }
    for (const noise_t& noise : list.noise) {
      LearntNoise& learnt = record_.noise[{noise.depth_min, noise.depth_max}];
      learnt.weight += noise.weight;
      learnt.pixel_px2 += noise.weight * noise.pixel_sigma * noise.pixel_sigma;
      learnt.disparity_px2 += noise.weight * noise.disparity_sigma * noise.disparity_sigma;
    }
  }

  void add_timing(const lcm::LogEvent& event) {
    timing_t timing{};
    reader_.decode(event, timing);
    if (timing.stages.empty()) return;
    record_.estimate.stage_ms["total, arrival to publish"].push_back(
        static_cast<double>(timing.stages.back().end - timing.arrival) * 1e-6);
    if (record_.processed.empty() || record_.processed.back() != timing.sequence) return;
    double sum_ns = 0.0;
    for (const stage_time_t& stage : timing.stages)
      sum_ns += static_cast<double>(stage.end - stage.start);
    record_.estimate.stage_ms[kAllStages].push_back(sum_ns * 1e-6);
  }

  std::string log_;
  log::LogReader reader_;
  Record& record_;
  Calibration calibration_;
  double depth_times_disparity_ = 0.0;
};

}  // namespace

Record read_record(const std::string& log) {
  const TemporaryFolder folder;
  log::export_log(log, folder.path());  // also refuses what is no record
  Record record{.estimate = read_result(folder.path()),
                .poses = {},
                .processed = {},
                .points = std::nullopt,
                .noise = {}};
  Evidence(log, record).run();
  return record;
}

}  // namespace egomod::eval
