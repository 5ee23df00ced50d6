// SPDX-License-Identifier: Apache-2.0
#include "egomod/publish/messages.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "egomod/publish/encoded_message.hpp"
#include "egomod/publish/image_encoder.hpp"
#include "example_frame.hpp"

namespace egomod {
namespace {

constexpr double kExact = 1e-12;
constexpr double kLinearisation = 1e-6;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

using RowMajor66 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using RowMajor33 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Vector3d vector(const double (&values)[3]) { return Eigen::Vector3d::Map(&values[0]); }
Matrix6d matrix(const double (&values)[6][6]) {
  return Eigen::Map<const RowMajor66>(&values[0][0]);
}
Eigen::Matrix3d matrix(const double (&values)[3][3]) {
  return Eigen::Map<const RowMajor33>(&values[0][0]);
}

Eigen::Isometry3d transform(const pose_t& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(pose.orientation[0], pose.orientation[1], pose.orientation[2],
                                  pose.orientation[3])
                   .toRotationMatrix();
  T.translation() = vector(pose.pos);
  return T;
}

// A camera above and ahead of the body's origin, looking along body x; the rig goes 1 m forward and
// turns left by 90 degrees (camera: about -y).
Frame quarter_turn() {
  Frame frame;
  frame.pair.calibration.T_body_camera = default_T_body_camera();
  frame.pair.calibration.T_body_camera.translation() = Eigen::Vector3d(0.5, 0.0, 1.0);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = so3_exp({0.0, -std::numbers::pi / 2, 0.0});
  T.translation() = Eigen::Vector3d(0.0, 0.0, 1.0);
  frame.motion.T_previous_current = T;
  frame.motion.T_first_current = T;
  frame.motion.exposure = std::chrono::milliseconds(500);
  frame.motion.status = EstimateStatus::kValid;
  return frame;
}

TEST(PoseMessage, GivesTheBodysOriginWhenTheCameraSitsElsewhere) {
  pose_t pose{};
  fill_message(quarter_turn(), pose);
  // The camera stands at x = 1.5, facing +y: the body's origin is 0.5 m behind it.
  EXPECT_TRUE(vector(pose.pos).isApprox(Eigen::Vector3d(1.5, -0.5, 0.0), kExact));
  EXPECT_NEAR(pose.orientation[0], std::sqrt(0.5), kExact);
  EXPECT_NEAR(pose.orientation[3], std::sqrt(0.5), kExact);
}

TEST(VelocityMessage, IsTheMeanInTheAxesOfTheCurrentBody) {
  velocity_t velocity{};
  fill_message(quarter_turn(), velocity);
  // Displacement (1.5, -0.5, 0) in previous axes is (-0.5, -1.5, 0) in current ones; over 0.5 s.
  EXPECT_TRUE(vector(velocity.vel).isApprox(Eigen::Vector3d(-1.0, -3.0, 0.0), kExact));
  EXPECT_TRUE(
      vector(velocity.rotation_rate).isApprox(Eigen::Vector3d(0, 0, std::numbers::pi), kExact));
  EXPECT_EQ(velocity.previous_utime, 0);
}

TEST(VelocityMessage, OfASkippedPairIsZeroWithItsStatus) {
  Frame frame = test::some_frame(3);
  frame.motion.status = EstimateStatus::kSkipped;
  velocity_t velocity{};
  fill_message(frame, velocity);
  EXPECT_EQ(velocity.status, pose_t::STATUS_SKIPPED);
  EXPECT_EQ(vector(velocity.vel).norm(), 0.0);
  EXPECT_EQ(velocity.previous_utime, velocity.utime);
}

// The message's covariance must be J S J^T with J the derivative of the message itself with respect
// to a right perturbation of the camera's motion.
TEST(PoseMessage, CovarianceIsThatOfARightPerturbationInTheBodyFrame) {
  const Frame frame = test::some_frame(5);
  pose_t pose{};
  fill_message(frame, pose);
  Matrix6d J;
  for (int i = 0; i < 6; ++i) {
    Frame moved = test::some_frame(5);
    const Vector6d xi = 1e-6 * Vector6d::Unit(i);
    moved.motion.T_first_current = frame.motion.T_first_current * se3_exp(xi);
    pose_t moved_pose{};
    fill_message(moved, moved_pose);
    J.col(i) = se3_log(transform(pose).inverse() * transform(moved_pose)) / 1e-6;
  }
  const Matrix6d expected = J * frame.motion.covariance_first_current * J.transpose();
  EXPECT_TRUE(matrix(pose.covariance).isApprox(expected, kLinearisation));
}

TEST(VelocityMessage, CovarianceIsThatOfARightPerturbationOfTheMotion) {
  Frame frame = test::some_frame(5);
  frame.motion.T_previous_current = se3_exp(Vector6d{0.3, 0.1, -0.2, 0.2, -0.4, 0.3});
  velocity_t velocity{};
  fill_message(frame, velocity);
  Matrix6d J;
  for (int i = 0; i < 6; ++i) {
    Frame moved = test::some_frame(5);
    const Vector6d xi = 1e-6 * Vector6d::Unit(i);
    moved.motion.T_previous_current = frame.motion.T_previous_current * se3_exp(xi);
    velocity_t shifted{};
    fill_message(moved, shifted);
    J.col(i) << (vector(shifted.vel) - vector(velocity.vel)) / 1e-6,
        (vector(shifted.rotation_rate) - vector(velocity.rotation_rate)) / 1e-6;
  }
  const Matrix6d expected = J * frame.motion.covariance_previous_current * J.transpose();
  EXPECT_TRUE(matrix(velocity.covariance).isApprox(expected, 10 * kLinearisation));
}

TEST(ObjectMessage, HoldsTheObjectInBodyAndWorldFrame) {
  Frame frame = quarter_turn();
  frame.objects.objects = {test::some_object(7)};
  object_list_t list{};
  EXPECT_EQ(fill_message(frame, list), 0);
  ASSERT_EQ(list.n_objects, 1);
  const object_t& object = list.objects[0];
  // Camera (right, down, forward) = (1, -0.5, 6) is body (6.5, -1, 1.5).
  EXPECT_TRUE(vector(object.body_pos).isApprox(Eigen::Vector3d(6.5, -1.0, 1.5), kExact));
  EXPECT_TRUE(vector(object.body_vel).isApprox(Eigen::Vector3d(-0.3, -0.4, 0.0), kExact));
  EXPECT_TRUE(vector(object.pos).isApprox(Eigen::Vector3d(2.5, 6.0, 1.5), kExact));
  EXPECT_TRUE(vector(object.vel).isApprox(Eigen::Vector3d(0.4, -0.3, 0.0), kExact));
  const Eigen::Vector3d body_variance(0.09, 0.01, 0.02);
  EXPECT_TRUE(matrix(object.body_pos_covariance)
                  .isApprox(Eigen::Matrix3d(body_variance.asDiagonal()), kExact));
  const Eigen::Vector3d world_variance(0.01, 0.09, 0.02);
  EXPECT_TRUE(
      matrix(object.pos_covariance).isApprox(Eigen::Matrix3d(world_variance.asDiagonal()), kExact));
}

TEST(ObjectMessage, LeavesOutWhatIsNotFinite) {
  Frame frame = test::some_frame(2);
  frame.objects.objects.push_back(test::some_object(8));
  frame.objects.objects[0].velocity_mps.x() = kNan;
  object_list_t list{};
  EXPECT_EQ(fill_message(frame, list), 1);
  ASSERT_EQ(list.objects.size(), 1U);
  EXPECT_EQ(list.objects[0].id, 8);
}

TEST(TrackMessage, JoinsTracksWithTheirRoleAndMotion) {
  Frame frame = test::some_frame(2);
  frame.tracks.tracks.emplace_back();  // not seen in this pair
  frame.tracks.max_tracks = 700;
  frame.objects.noise = {
      {.least_depth_m = 2.0, .most_depth_m = 4.0, .is_rich = true, .disparity_sigma_px = 0.25}};
  track_list_t list{};
  EXPECT_EQ(fill_message(frame, list), 0);
  ASSERT_EQ(list.n_tracks, 2);
  EXPECT_EQ(list.max_tracks, 700);
  ASSERT_EQ(list.n_noise, 1);
  EXPECT_EQ(list.noise[0].depth_max, 4.0);
  EXPECT_TRUE(list.noise[0].rich != 0);
  EXPECT_EQ(list.noise[0].disparity_sigma, 0.25);
  EXPECT_EQ(list.tracks[0].role, track_t::ROLE_INLIER);
  EXPECT_EQ(list.tracks[0].state, track_t::STATE_UNKNOWN);
  EXPECT_EQ(list.tracks[1].state, track_t::STATE_MOVING);
  EXPECT_EQ(list.tracks[1].object_id, 7);
  EXPECT_EQ(list.tracks[1].evidence, 9.5F);
  EXPECT_EQ(list.tracks[1].chi2, 40.25F);
}

TEST(TrackMessage, HasNoVelocityWhileItIsUnknown) {
  Frame frame = test::some_frame(2);
  for (PointMotion& point : frame.objects.points) point.velocity_mps = {0.4, 0.0, -0.3};
  track_list_t list{};
  EXPECT_EQ(fill_message(frame, list), 0);
  const auto moves = [](const track_t& track) {
    return track.vel[0] != 0.0F || track.vel[1] != 0.0F || track.vel[2] != 0.0F;
  };
  ASSERT_TRUE(std::any_of(list.tracks.begin(), list.tracks.end(), moves));
  for (PointMotion& point : frame.objects.points) point.state = PointState::kUnknown;
  EXPECT_EQ(fill_message(frame, list), 0);
  EXPECT_TRUE(std::none_of(list.tracks.begin(), list.tracks.end(), moves));
}

TEST(Messages, KeepEverythingThroughEncodingAndDecoding) {
  object_list_t list{};
  EXPECT_EQ(fill_message(test::some_frame(2), list), 0);
  std::vector<std::uint8_t> buffer;
  const auto bytes = encode_message(list, buffer);
  object_list_t decoded{};
  ASSERT_EQ(decoded.decode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  EXPECT_EQ(decoded.sequence, 2);
  ASSERT_EQ(decoded.objects.size(), 1U);
  EXPECT_EQ(vector(decoded.objects[0].pos), vector(list.objects[0].pos));
  EXPECT_EQ(decoded.objects[0].u_min, list.objects[0].u_min);
}

TEST(CalibrationMessage, ComesBackExactly) {
  Calibration calibration = test::some_frame(0).pair.calibration;
  calibration.images_are_raw = true;
  calibration.left = {.width_px = 70, .height_px = 50, .distortion = {0.1, -0.2, 0.3, -0.4, 0.5}};
  calibration.left.K(0, 2) = 30.1;
  calibration.right.R_rectified_raw = so3_exp({0.01, 0.02, 0.03});
  calibration.R_right_left = so3_exp({0.03, -0.02, 0.01});
  calibration.t_right_left_m = {-0.375, 0.001, 0.002};
  calibration_t message{};
  fill_message(calibration, true, message);
  EXPECT_TRUE(calibration_from(message) == calibration);
  EXPECT_TRUE(is_finite(message));
}

TEST(Messages, SeeWhatIsNotFinite) {
  Frame frame = test::some_frame(1);
  frame.motion.covariance_first_current(3, 4) = kNan;
  pose_t pose{};
  fill_message(frame, pose);
  EXPECT_FALSE(is_finite(pose));
  velocity_t velocity{};
  fill_message(frame, velocity);
  EXPECT_TRUE(is_finite(velocity));
}

TEST(ImageEncoder, PacksRowsAndCompresses) {
  const Frame frame = test::some_frame(0);
  bot_core::image_t raw{};
  ImageEncoder(ImageEncoding::kRaw, 0).encode(frame.pair.left.view(), 5, raw);
  EXPECT_EQ(raw.size, 64 * 48);
  EXPECT_EQ(raw.data[64 * 3 + 2], frame.pair.left.row(3)[2]);
  bot_core::image_t jpeg{};
  ImageEncoder(ImageEncoding::kJpeg, 90).encode(frame.pair.left.view(), 5, jpeg);
  EXPECT_EQ(jpeg.pixelformat, bot_core::image_t::PIXEL_FORMAT_MJPEG);
  EXPECT_LT(jpeg.size, raw.size);
  EXPECT_EQ(jpeg.data[0], 0xFF);
  EXPECT_EQ(jpeg.data[1], 0xD8);
}

}  // namespace
}  // namespace egomod
