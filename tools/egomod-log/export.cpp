// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <egomod/object_list_t.hpp>
#include <egomod/pose_t.hpp>
#include <egomod/timing_t.hpp>
#include <filesystem>
#include <optional>

#include "commands.hpp"
#include "egomod/publish/messages.hpp"
#include "log_reader.hpp"
#include "text_output.hpp"

namespace egomod::log {
namespace {

namespace fs = std::filesystem;

// A live run may have dropped pairs; more than this is not one run.
constexpr std::int64_t kMostMissingPairs = 1'000'000;

double seconds(std::int64_t utime_us) { return static_cast<double>(utime_us) * 1e-6; }

bool brings_a_pose(const pose_t& pose) {
  return pose.status == pose_t::STATUS_VALID || pose.status == pose_t::STATUS_FIRST ||
         pose.status == pose_t::STATUS_AMBIGUOUS;
}

Eigen::Isometry3d world_from_body(const pose_t& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const auto& q = pose.orientation;
  T.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d::Map(pose.pos);
  return T;
}

// Rows of poses.txt and times.txt: one for each left image, whatever became of it.
class PoseRows {
 public:
  // `interval_us`: between two pairs before the first that the log speaks of.
  PoseRows(const fs::path& folder, std::int64_t interval_us)
      : poses_(folder / "poses.txt"), times_(folder / "times.txt"), interval_us_(interval_us) {}

  void add(const pose_t& pose, const Eigen::Isometry3d& T_body_camera, const std::string& log) {
    const std::int64_t missing = pose.sequence - rows_;
    if (missing < 0 || missing > kMostMissingPairs) {
      throw LogError(log + ": pose " + std::to_string(pose.sequence) + " follows " +
                     std::to_string(rows_) + " others; export one run at a time");
    }
    fill_gap(pose);
    if (brings_a_pose(pose)) {
      T_first_current_ = T_body_camera.inverse() * world_from_body(pose) * T_body_camera;
    }
    write_row(pose.utime);
  }

  void close() {
    poses_.close();
    times_.close();
  }

 private:
  // Pairs of which the log says nothing repeat the pose; their times lie evenly in the gap.
  void fill_gap(const pose_t& next) {
    const std::int64_t first = rows_;
    const std::int64_t steps = next.sequence - first + 1;
    const std::int64_t from_us = first == 0 ? next.utime - steps * interval_us_ : last_utime_us_;
    for (std::int64_t i = 1; i < steps; ++i)
      write_row(from_us + (next.utime - from_us) * i / steps);
  }

  void write_row(std::int64_t utime_us) {
    const Eigen::Matrix4d& T = T_first_current_.matrix();
    for (int i = 0; i < 12; ++i) poses_.print("{:.9e}{}", T(i / 4, i % 4), i == 11 ? '\n' : ' ');
    times_.print("{:.6f}\n", seconds(utime_us));
    last_utime_us_ = utime_us;
    ++rows_;
  }

  TextOutput poses_;
  TextOutput times_;
  Eigen::Isometry3d T_first_current_ = Eigen::Isometry3d::Identity();
  std::int64_t interval_us_;
  std::int64_t rows_ = 0;
  std::int64_t last_utime_us_ = 0;
};

// Mean interval of the first two pairs that the log speaks of; that of 30 Hz if there is one only.
std::int64_t first_interval_us(const std::string& log) {
  constexpr std::int64_t kDefault_us = 33'333;
  LogReader reader(log);
  std::optional<pose_t> first;
  pose_t pose{};
  while (const lcm::LogEvent* event = reader.next()) {
    if (event->channel != "EGOMOD_POSE") continue;
    reader.decode(*event, pose);
    if (first && pose.sequence > first->sequence) {
      return std::max<std::int64_t>(
          1, (pose.utime - first->utime) / (pose.sequence - first->sequence));
    }
    first = pose;
  }
  return kDefault_us;
}

class ObjectRows {
 public:
  explicit ObjectRows(const fs::path& folder) : file_(folder / "objects.csv") {
    file_.print("frame,time,track_id,u_min,v_min,u_max,v_max,X,Y,Z,VX,VY,VZ,n_points\n");
  }

  void add(const object_list_t& list, const Eigen::Isometry3d& T_body_camera) {
    const Eigen::Isometry3d T_camera_body = T_body_camera.inverse();
    for (const object_t& object : list.objects) {
      if (object.state != object_t::STATE_MOVING || object.n_points <= 0) continue;
      const Eigen::Vector3d P = T_camera_body * Eigen::Vector3d::Map(object.body_pos);
      const Eigen::Vector3d V = T_camera_body.linear() * Eigen::Vector3d::Map(object.body_vel);
      file_.print("{},{:.6f},{},{:.3f},{:.3f},{:.3f},{:.3f},", list.sequence, seconds(list.utime),
                  object.id, object.u_min, object.v_min, object.u_max, object.v_max);
      file_.print("{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{}\n", P.x(), P.y(), P.z(), V.x(),
                  V.y(), V.z(), object.n_points);
    }
  }

  void close() { file_.close(); }

 private:
  TextOutput file_;
};

// The file is there only if the log has timing; one of an earlier export would be another run's.
class TimingRows {
 public:
  explicit TimingRows(const fs::path& folder) : path_(folder / "timing.csv") {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }

  void add(const timing_t& timing) {
    if (!file_) {
      file_.emplace(path_);
      file_->print("frame,time,stage,ms\n");
    }
    for (const stage_time_t& stage : timing.stages) {
      file_->print("{},{:.6f},{},{:.6f}\n", timing.sequence, seconds(timing.utime), stage.name,
                   static_cast<double>(stage.end - stage.start) * 1e-6);
    }
  }

  void close() {
    if (file_) file_->close();
  }

 private:
  fs::path path_;
  std::optional<TextOutput> file_;
};

class Export {
 public:
  Export(const std::string& log, const fs::path& folder)
      : log_(log),
        reader_(log),
        poses_(folder, first_interval_us(log)),
        objects_(folder),
        timing_(folder) {}

  void run() {
    while (const lcm::LogEvent* event = reader_.next()) add(*event);
    poses_.close();
    objects_.close();
    timing_.close();
    if (poses_seen_ == 0) {
      reader_.require_whole();
      throw LogError(log_ + ": holds no EGOMOD_POSE; record it with egomodd --record");
    }
    reader_.require_whole();
  }

 private:
  void add(const lcm::LogEvent& event) {
    if (event.channel == "EGOMOD_CALIBRATION") {
      reader_.decode(event, calibration_);
      T_body_camera_ = calibration_from(calibration_).T_body_camera;
    } else if (event.channel == "EGOMOD_POSE") {
      reader_.decode(event, pose_);
      poses_.add(pose_, T_body_camera(), log_);
      ++poses_seen_;
    } else if (event.channel == "EGOMOD_OBJECTS") {
      reader_.decode(event, list_);
      objects_.add(list_, T_body_camera());
    } else if (event.channel == "EGOMOD_TIMING") {
      reader_.decode(event, times_);
      timing_.add(times_);
    }
  }

  [[nodiscard]] const Eigen::Isometry3d& T_body_camera() const {
    if (T_body_camera_) return *T_body_camera_;
    throw LogError(log_ +
                   ": no EGOMOD_CALIBRATION before the first pose or object; it says where " +
                   "the camera sits on the body");
  }

  std::string log_;
  LogReader reader_;
  PoseRows poses_;
  ObjectRows objects_;
  TimingRows timing_;
  std::optional<Eigen::Isometry3d> T_body_camera_;
  std::int64_t poses_seen_ = 0;
  calibration_t calibration_{};
  pose_t pose_{};
  object_list_t list_{};
  timing_t times_{};
};

}  // namespace

void export_log(const std::string& log, const std::string& folder) {
  static_cast<void>(LogReader(log));  // a log that is not there must leave the folder alone
  make_folder(folder);
  Export(log, folder).run();
}

}  // namespace egomod::log
