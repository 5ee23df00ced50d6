// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "egomod/publish/messages.hpp"

namespace egomod {
namespace {

using RowMajor33 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

static_assert(static_cast<int>(ObjectState::kStopped) == object_t::STATE_STOPPED);
static_assert(static_cast<int>(TrackRole::kOutlier) == track_t::ROLE_OUTLIER);
static_assert(static_cast<int>(PointState::kUnobservable) == track_t::STATE_UNOBSERVABLE);

void write(const Eigen::Vector3d& from, double (&to)[3]) {
  Eigen::Vector3d::Map(static_cast<double*>(to)) = from;
}

void write_rotated(const Eigen::Matrix3d& R, const Eigen::Matrix3d& covariance,
                   double (&to)[3][3]) {
  Eigen::Map<RowMajor33> matrix(&to[0][0]);
  matrix = R * covariance * R.transpose();
}

bool is_finite(const MovingObject& object) {
  const PixelRect& r = object.rectangle;
  const double numbers[] = {object.age_s,
                            r.u_min_px,
                            r.v_min_px,
                            r.u_max_px,
                            r.v_max_px,
                            object.speed_mps,
                            object.speed_sigma_mps,
                            object.motion_probability};
  return object.position_m.allFinite() && object.position_covariance_m2.allFinite() &&
         object.velocity_mps.allFinite() && object.velocity_covariance_m2ps2.allFinite() &&
         object.angular_velocity_radps.allFinite() && object.extent_m.allFinite() &&
         std::all_of(std::begin(numbers), std::end(numbers),
                     [](double x) { return std::isfinite(x); });
}

void fill_in_body(const MovingObject& object, const Eigen::Isometry3d& T_body_camera,
                  object_t& message) {
  const Eigen::Matrix3d R = T_body_camera.linear();
  write(T_body_camera * object.position_m, message.body_pos);
  write_rotated(R, object.position_covariance_m2, message.body_pos_covariance);
  write(R * object.velocity_mps, message.body_vel);
  write_rotated(R, object.velocity_covariance_m2ps2, message.body_vel_covariance);
  write(R * object.angular_velocity_radps, message.body_rotation_rate);
}

void fill_in_world(const MovingObject& object, const Eigen::Isometry3d& T_world_camera,
                   object_t& message) {
  const Eigen::Matrix3d R = T_world_camera.linear();
  write(T_world_camera * object.position_m, message.pos);
  write_rotated(R, object.position_covariance_m2, message.pos_covariance);
  write(R * object.velocity_mps, message.vel);
  write_rotated(R, object.velocity_covariance_m2ps2, message.vel_covariance);
}

void fill_rest(const MovingObject& object, object_t& message) {
  message.id = object.id;
  message.state = static_cast<std::int8_t>(object.state);
  message.age = object.age_s;
  message.u_min = object.rectangle.u_min_px;
  message.v_min = object.rectangle.v_min_px;
  message.u_max = object.rectangle.u_max_px;
  message.v_max = object.rectangle.v_max_px;
  write(object.extent_m, message.extent);
  message.n_points = object.points;
  message.speed = object.speed_mps;
  message.speed_sigma = object.speed_sigma_mps;
  message.motion_probability = object.motion_probability;
}

bool is_finite(const track_t& message) {
  return std::isfinite(message.u) && std::isfinite(message.v) && std::isfinite(message.disparity) &&
         std::isfinite(message.evidence) && std::isfinite(message.chi2) &&
         std::all_of(std::begin(message.vel), std::end(message.vel),
                     [](float x) { return std::isfinite(x); });
}

void fill_motion(const PointMotion& motion, const Eigen::Matrix3d& R_body_camera,
                 track_t& message) {
  message.state = static_cast<std::int8_t>(motion.state);
  message.object_id = motion.object_id;
  if (motion.state != PointState::kUnknown)
    Eigen::Vector3f::Map(message.vel) = (R_body_camera * motion.velocity_mps).cast<float>();
  message.evidence = motion.evidence;
  message.chi2 = motion.chi2;
}

track_t track_message(const Track& track, TrackRole role) {
  track_t message{};
  message.id = static_cast<std::int64_t>(track.id);
  message.u = track.current.u_px;
  message.v = track.current.v_px;
  message.disparity = track.current.disparity_px;
  message.age = static_cast<std::int32_t>(track.age);
  message.role = static_cast<std::int8_t>(role);
  return message;
}

using MotionsById = std::vector<const PointMotion*>;

MotionsById by_id(const std::vector<PointMotion>& points) {
  MotionsById sorted;
  sorted.reserve(points.size());
  for (const PointMotion& point : points) sorted.push_back(&point);
  std::stable_sort(sorted.begin(), sorted.end(), [](const PointMotion* a, const PointMotion* b) {
    return a->track_id < b->track_id;
  });
  return sorted;
}

const PointMotion* find(const MotionsById& motions, std::uint64_t track_id) {
  const auto at = std::lower_bound(
      motions.begin(), motions.end(), track_id,
      [](const PointMotion* motion, std::uint64_t id) { return motion->track_id < id; });
  return at != motions.end() && (*at)->track_id == track_id ? *at : nullptr;
}

noise_t noise_message(const NoiseBin& bin) {
  noise_t message{};
  message.depth_min = bin.least_depth_m;
  message.depth_max = bin.most_depth_m;
  message.rich = bin.is_rich ? 1 : 0;
  message.old = bin.is_old ? 1 : 0;
  message.weight = bin.weight;
  message.pixel_factor = bin.pixel_factor;
  message.disparity_factor = bin.disparity_factor;
  message.pixel_sigma = bin.pixel_sigma_px;
  message.disparity_sigma = bin.disparity_sigma_px;
  return message;
}

}  // namespace

int fill_message(const Frame& frame, object_list_t& message) {
  const Eigen::Isometry3d& T_body_camera = frame.pair.calibration.T_body_camera;
  const Eigen::Isometry3d T_world_camera = world_from_body(frame) * T_body_camera;
  const bool has_pose = T_world_camera.matrix().allFinite();
  message.utime = frame.pair.utime_us();
  message.sequence = static_cast<std::int64_t>(frame.pair.sequence);
  message.objects.clear();
  int left_out = 0;
  for (const MovingObject& object : frame.objects.objects) {
    if (!has_pose || !is_finite(object)) {
      ++left_out;
      continue;
    }
    object_t& out = message.objects.emplace_back();
    fill_in_body(object, T_body_camera, out);
    fill_in_world(object, T_world_camera, out);
    fill_rest(object, out);
  }
  message.n_objects = static_cast<std::int32_t>(message.objects.size());
  return left_out;
}

int fill_message(const Frame& frame, track_list_t& message) {
  const Eigen::Matrix3d R_body_camera = frame.pair.calibration.T_body_camera.linear();
  const MotionsById motions = by_id(frame.objects.points);
  message.utime = frame.pair.utime_us();
  message.sequence = static_cast<std::int64_t>(frame.pair.sequence);
  message.tracks.clear();
  int left_out = 0;
  for (std::size_t i = 0; i < frame.tracks.tracks.size(); ++i) {
    const Track& track = frame.tracks.tracks[i];
    if (!track.has_current) continue;
    const bool has_role = i < frame.motion.roles.size();
    track_t out = track_message(track, has_role ? frame.motion.roles[i] : TrackRole::kUnused);
    if (const PointMotion* motion = find(motions, track.id))
      fill_motion(*motion, R_body_camera, out);
    if (is_finite(out)) {
      message.tracks.push_back(out);
    } else {
      ++left_out;
    }
  }
  message.max_tracks = frame.tracks.max_tracks;
  message.n_tracks = static_cast<std::int32_t>(message.tracks.size());
  message.noise.clear();
  for (const NoiseBin& bin : frame.objects.noise) message.noise.push_back(noise_message(bin));
  message.n_noise = static_cast<std::int32_t>(message.noise.size());
  return left_out;
}

}  // namespace egomod
