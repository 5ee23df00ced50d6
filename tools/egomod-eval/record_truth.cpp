// SPDX-License-Identifier: Apache-2.0
#include "record_truth.hpp"

#include <egomod/truth_object_list_t.hpp>
#include <egomod/truth_pose_t.hpp>
#include <filesystem>

#include "egomod/publish/messages.hpp"
#include "log_reader.hpp"
#include "tables.hpp"

namespace egomod::eval {
namespace {

using Eigen::Vector3d;

Eigen::Isometry3d transform(const double (&pos)[3], const double (&orientation)[4]) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Eigen::Quaterniond q(orientation[0], orientation[1], orientation[2], orientation[3]);
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = Vector3d::Map(pos);
  return T;
}

class TruthOfRecord {
 public:
  explicit TruthOfRecord(const std::string& log) : log_(log), reader_(log) {}

  Truth read() {
    while (const lcm::LogEvent* event = reader_.next()) add(*event);
    reader_.require_whole();
    if (times_s_.size() < 2) {
      throw InputError(log_ + ": holds no truth, as a record of --source sim does; give --truth");
    }
    truth_.name = std::filesystem::path(log_).stem();
    truth_.times_s = dense_times();
    return std::move(truth_);
  }

 private:
  void add(const lcm::LogEvent& event) {
    if (event.channel == "EGOMOD_CALIBRATION") {
      calibration_t message{};
      reader_.decode(event, message);
      T_camera_body_ = calibration_from(message).T_body_camera.inverse();
      truth_.focal_px = message.fx;
      truth_.cx_px = message.cx;
      truth_.cy_px = message.cy;
      truth_.baseline_m = message.baseline;
    } else if (event.channel == "SIM_TRUTH_POSE") {
      truth_pose_t message{};
      reader_.decode(event, message);
      add_pose(message);
    } else if (event.channel == "SIM_TRUTH_OBJECTS") {
      truth_object_list_t message{};
      reader_.decode(event, message);
      add_objects(message);
    }
  }

  void add_pose(const truth_pose_t& message) {
    const int frame = static_cast<int>(message.sequence);
    if (frame < 0 || (!times_s_.empty() && frame <= times_s_.rbegin()->first)) {
      throw InputError(log_ + ": SIM_TRUTH_POSE: sequences must ascend from 0; " +
                       std::to_string(message.sequence) + " does not");
    }
    times_s_[frame] = 1e-6 * static_cast<double>(message.utime);
    const Eigen::Isometry3d T_world_body = transform(message.pos, message.orientation);
    truth_.poses.push_back({frame, T_camera_body_ * T_world_body * T_camera_body_.inverse()});
  }

  void add_objects(const truth_object_list_t& message) {
    if (!truth_.objects) truth_.objects.emplace();
    auto& objects = (*truth_.objects)[static_cast<int>(message.sequence)];
    for (const truth_object_t& from : message.objects) {
      objects.push_back(truth_object(from, 1e-6 * static_cast<double>(message.utime)));
    }
  }

  [[nodiscard]] TruthObject truth_object(const truth_object_t& from, double time_s) const {
    const Vector3d surface_m = T_camera_body_ * Vector3d::Map(from.body_pos);
    return {.id = std::to_string(from.id),
            .type = "-",
            .time_s = time_s,
            .surface_m = surface_m,
            // What is seen of a thing is its front.
            .centre_m = surface_m + Vector3d(0.0, 0.0, 0.5 * from.extent[2]),
            .velocity_mps = T_camera_body_.linear() * Vector3d::Map(from.body_vel),
            .rectangle = {from.u_min, from.v_min, from.u_max, from.v_max},
            .visible_px = from.visible,
            .moving = from.moving != 0};
  }

  [[nodiscard]] std::vector<double> dense_times() const {
    std::vector<double> times_s;
    for (auto next = times_s_.begin(); next != times_s_.end(); ++next) {
      // Before the first one time runs as after it.
      const auto from = next == times_s_.begin() ? next : std::prev(next);
      const auto to = next == times_s_.begin() ? std::next(next) : next;
      const double interval_s = (to->second - from->second) / (to->first - from->first);
      while (static_cast<int>(times_s.size()) < next->first) {
        times_s.push_back(next->second -
                          interval_s * (next->first - static_cast<int>(times_s.size())));
      }
      times_s.push_back(next->second);
    }
    return times_s;
  }

  std::string log_;
  log::LogReader reader_;
  Truth truth_;
  std::map<int, double> times_s_;
  Eigen::Isometry3d T_camera_body_ = default_T_body_camera().inverse();
};

}  // namespace

Truth read_truth_of_record(const std::string& log) { return TruthOfRecord(log).read(); }

}  // namespace egomod::eval
