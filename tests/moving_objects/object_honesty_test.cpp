// SPDX-License-Identifier: Apache-2.0
// Are velocities and places of objects as true as their covariances say?
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "egomod/moving_objects/moving_object_detector.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

using synthetic::World;

constexpr unsigned kSeeds = 20;
constexpr std::size_t kBackground = 300;

double nees(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  return error.dot(covariance.inverse() * error) / 3.0;
}

// A box before a resting rig; the points of the box come after those of the background.
struct Scene {
  explicit Scene(unsigned seed, int points = 40,
                 const Eigen::Vector3d& velocity_mps = {0.4, 0.0, 0.1})
      : world(seed) {
    world.pixel_sigma = 0.18;
    world.disparity_sigma_px = 0.25;
    world.rig_velocity_mps.setZero();
    world.rig_yaw_rate_radps = 0.0;
    world.add_background(static_cast<int>(kBackground));
    world.add_box(points, centre_m, {0.6, 0.6, 0.3}, velocity_mps);
  }

  // From this pair on each point of the box moves as `velocity_of` its place says.
  template <typename Field>
  void move_on(int pair, const Field& velocity_of) {
    const double t_s = world.time_s(pair);
    for (std::size_t i = kBackground; i < world.points.size(); ++i) {
      synthetic::Point& point = world.points[i];
      const Eigen::Vector3d at_m = point.at_start_m + t_s * point.velocity_mps;
      point.velocity_mps = velocity_of(at_m);
      point.at_start_m = at_m - t_s * point.velocity_mps;
    }
  }
  void see(int pair) {
    const TrackSet tracks = world.tracks(pair);
    detector.detect(tracks, world.motion(tracks, pair), objects);
  }
  // The only one; nothing where there is none, or more.
  [[nodiscard]] const MovingObject* moving() const {
    return objects.objects.size() == 1 && objects.objects.front().state == ObjectState::kMoving
               ? &objects.objects.front()
               : nullptr;
  }

  Eigen::Vector3d centre_m{-0.8, 0.1, 5.0};
  World world;
  MovingObjectDetector detector{{.method = MovingObjectsMethod::kFilter}};
  MovingObjects objects;
};

struct MeanNees {
  double velocity = 0.0;
  double position = 0.0;
};

MeanNees mean_nees(int points) {
  const Eigen::Vector3d velocity_mps{0.4, 0.0, 0.1};
  MeanNees mean;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Scene scene(seed, points, velocity_mps);
    int pair = 0;
    for (; pair < 60; ++pair) scene.see(pair);
    const MovingObject* object = scene.moving();
    if (object == nullptr) return {NAN, NAN};
    const Eigen::Vector3d centre_m = scene.centre_m + scene.world.time_s(pair - 1) * velocity_mps;
    mean.velocity +=
        nees(object->velocity_mps - velocity_mps, object->velocity_covariance_m2ps2) / kSeeds;
    mean.position += nees(object->position_m - centre_m, object->position_covariance_m2) / kSeeds;
  }
  return mean;
}

TEST(ObjectHonesty, SteadyVelocityErrsAsItsCovarianceSays) {
  const MeanNees mean = mean_nees(40);
  // Noise that is white, as here, is what it has least of in images: it errs less than it says.
  EXPECT_GT(mean.velocity, 0.1);
  EXPECT_LT(mean.velocity, 1.4);
}

struct Found {
  double nees = 0.0;
  double late_mps = 0.0;  // by how much the velocity is still behind
};

// Of an object that leaves along the line of sight, in the first pair in which it is MOVING: means.
Found when_found(double rest_s) {
  const Eigen::Vector3d velocity_mps{0.0, 0.0, 0.4};
  Found mean;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Scene scene(seed, 40, rest_s > 0.0 ? Eigen::Vector3d::Zero() : velocity_mps);
    int pair = 0;
    for (; scene.world.time_s(pair) < rest_s; ++pair) scene.see(pair);
    scene.move_on(pair, [&](const auto&) { return velocity_mps; });
    for (; scene.moving() == nullptr; ++pair) {
      if (scene.world.time_s(pair) > rest_s + 2.0) return {NAN, NAN};
      scene.see(pair);
    }
    const MovingObject& object = *scene.moving();
    const Eigen::Vector3d error_mps = object.velocity_mps - velocity_mps;
    mean.nees += nees(error_mps, object.velocity_covariance_m2ps2) / kSeeds;
    mean.late_mps -= error_mps.z() / kSeeds;
  }
  return mean;
}

TEST(ObjectHonesty, VelocityOfWhatHasJustBeenFoundIsSaidToBeUnsure) {
  EXPECT_LT(when_found(0.0).nees, 2.0);
  EXPECT_LT(when_found(1.0).nees, 4.0);
}

TEST(ObjectHonesty, VelocityOfWhatStartsIsNotBehindForLong) {
  // The filters alone, which have learnt to rest, are behind by more than half of it.
  EXPECT_LT(std::abs(when_found(1.0).late_mps), 0.15);
}

TEST(ObjectHonesty, PlaceOfASurfaceThatFewPointsShowErrsAsItsCovarianceSays) {
  for (const int points : {8, 40}) {
    const MeanNees mean = mean_nees(points);
    EXPECT_GT(mean.position, 0.05) << points;
    EXPECT_LT(mean.position, 2.0) << points;
  }
}

struct Braking {
  double nees = 0.0;
  double late_mps = 0.0;  // by how much the velocity is still the one of before
};

// Mean over seeds, while it brakes by 1 m/s^2.
Braking while_braking() {
  Braking mean;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Eigen::Vector3d velocity_mps{0.8, 0.0, 0.0};
    Scene scene(seed, 40, velocity_mps);
    int pair = 0;
    for (; pair < 45; ++pair) scene.see(pair);
    for (; pair < 57; ++pair) {
      velocity_mps.x() -= 1.0 / scene.world.rate_hz;
      scene.move_on(pair - 1, [&](const auto&) { return velocity_mps; });
      scene.see(pair);
    }
    const MovingObject* object = scene.moving();
    if (object == nullptr) return {NAN, NAN};
    const Eigen::Vector3d error_mps = object->velocity_mps - velocity_mps;
    mean.nees += nees(error_mps, object->velocity_covariance_m2ps2) / kSeeds;
    mean.late_mps += error_mps.x() / kSeeds;
  }
  return mean;
}

TEST(ObjectHonesty, BrakingIsFollowedAndShowsInTheErrorOfTheVelocity) {
  const Braking mean = while_braking();
  EXPECT_GT(mean.nees, 0.1);
  EXPECT_LT(mean.nees, 1.4);
  EXPECT_LT(std::abs(mean.late_mps), 0.02);
}

TEST(ObjectHonesty, BodyThatTurnsAsItDrivesHasItsRate) {
  const Eigen::Vector3d turn_radps{0.0, 0.8, 0.0};
  const Eigen::Vector3d drive_mps{0.5, 0.0, 0.0};
  Eigen::Vector3d mean_radps = Eigen::Vector3d::Zero();
  double mean_nees = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Scene scene(seed, 80, drive_mps);
    for (int pair = 0; pair < 45; ++pair) {
      const Eigen::Vector3d axis_m = scene.centre_m + scene.world.time_s(pair) * drive_mps;
      scene.move_on(pair, [&](const Eigen::Vector3d& at_m) -> Eigen::Vector3d {
        return drive_mps + turn_radps.cross(at_m - axis_m);
      });
      scene.see(pair);
    }
    const MovingObject* object = scene.moving();
    ASSERT_NE(object, nullptr) << "seed " << seed;
    mean_radps += object->angular_velocity_radps / kSeeds;
    mean_nees += nees(object->velocity_mps - drive_mps, object->velocity_covariance_m2ps2) / kSeeds;
  }
  EXPECT_LT((mean_radps - turn_radps).norm(), 0.2);
  EXPECT_GT(mean_nees, 0.05);
  EXPECT_LT(mean_nees, 1.4);
}

}  // namespace
}  // namespace egomod
