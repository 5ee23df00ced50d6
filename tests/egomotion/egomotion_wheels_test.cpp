// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>

#include "../moving_objects/counted_new.hpp"
#include "egomotion_fixture.hpp"

namespace egomod {
namespace {

using synthetic::World;

constexpr double kDtS = 1.0 / 30.0;
constexpr int kPairs = 90;
constexpr int kFaultComes = 45;
constexpr double kDraggedM = 0.005;  // in one pair; the rig makes 0.015

struct Outcome {
  int ambiguous = 0;
  int dragged = 0;
  int dragged_silently = 0;
  int worst_ambiguous_quality = 0;
  double end_error_m = 0.0;
  double end_error_sigmas = 0.0;
};

Eigen::Isometry3d walking() {
  Vector6d xi;
  xi << 0.0, 0.0, 0.015, 0.0, -0.004, 0.0;
  return se3_exp(xi);
}

Eigen::Isometry3d resting() { return Eigen::Isometry3d::Identity(); }

// With slip the wheels count more than the rig drives.
Eigen::Isometry3d slipping(const Eigen::Isometry3d& T, double slip) {
  return se3_exp(se3_log(T) / (1.0 - slip));
}

// Of one pair: how the rig moves, and what its wheels count, both in left camera frames.
struct Step {
  Eigen::Isometry3d rig;
  Eigen::Isometry3d wheels;
};

// Wheels in a frame of their own, somewhere else and turned.
class Wheels {
 public:
  void follow(const Eigen::Isometry3d& T_previous_current, TrackSet& tracks) {
    T_wheels_camera_ = T_wheels_camera_ * T_previous_current;
    tracks.T_body_camera.translation() = Eigen::Vector3d(0.1, 0.2, 0.4);
    tracks.wheels = WheelPose{T_wheels_camera_ * tracks.T_body_camera.inverse(), stretch};
  }
  std::uint32_t stretch = 0;

 private:
  Eigen::Isometry3d T_wheels_camera_ = [] {
    Vector6d xi;
    xi << 3.0, -2.0, 1.0, 0.0, 0.0, 2.0;
    return se3_exp(xi) * default_T_body_camera();
  }();
};

Outcome run(World&& world, const std::function<Step(World&, int)>& step,
            const EgomotionConfig& config = {}) {
  EgomotionEstimator estimator(config);
  Egomotion motion;
  Outcome outcome;
  Wheels wheels;
  wheels.follow(resting(), world.tracks());
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < kPairs; ++k) {
    const Step now = step(world, k);
    world.step(now.rig, kDtS);
    wheels.follow(now.wheels, world.tracks());
    estimator.estimate(world.tracks(), motion);
    const bool ambiguous = motion.status == EstimateStatus::kAmbiguous;
    const bool dragged = error_of(motion, now.rig).head<3>().norm() > kDraggedM;
    outcome.ambiguous += ambiguous ? 1 : 0;
    outcome.dragged += dragged ? 1 : 0;
    outcome.dragged_silently += dragged && !ambiguous ? 1 : 0;
    if (ambiguous)
      outcome.worst_ambiguous_quality = std::max(outcome.worst_ambiguous_quality, motion.quality);
  }
  const Vector6d e = se3_log(motion.T_first_current.inverse() * world.T_first_current());
  outcome.end_error_m = e.head<3>().norm();
  outcome.end_error_sigmas = std::sqrt(e.dot(motion.covariance_first_current.ldlt().solve(e)));
  return outcome;
}

// A mover on that share of the image leads at nearly the rig's own speed.
Outcome behind_a_leader(std::uint32_t seed, double share, double slip,
                        const EgomotionConfig& config = {}) {
  return run(
      World(seed, 500, share),
      [&](World& world, int) {
        world.mover_velocity_m = 0.95 * world.T_first_current().linear() * walking().translation();
        return Step{walking(), slipping(walking(), slip)};
      },
      config);
}

TEST(EgomotionWheels, TheyTellWhoMovesThoughTheySlip) {
  for (const double share : {0.5, 0.6})
    for (const double slip : {0.0, 0.1})
      for (std::uint32_t seed = 0; seed < 3; ++seed) {
        const Outcome outcome = behind_a_leader(seed, share, slip);
        EXPECT_LE(outcome.dragged, 1) << share << ' ' << slip << ' ' << seed;
        EXPECT_EQ(outcome.dragged_silently, 0) << share << ' ' << slip << ' ' << seed;
        EXPECT_LT(outcome.end_error_m, 0.05) << share << ' ' << slip << ' ' << seed;
      }
}

TEST(EgomotionWheels, WithoutThemALeaderOnMostOfTheImageIsTakenForTheWorld) {
  EgomotionConfig config;
  config.wheels.enable = false;
  EXPECT_GT(behind_a_leader(1, 0.8, 0.0, config).dragged, kPairs / 2);
}

TEST(EgomotionWheels, AWorldThatAllMovesIsNotFollowedInSilence) {
  const Outcome outcome = behind_a_leader(1, 1.0, 0.1);
  EXPECT_EQ(outcome.dragged_silently, 0);
  EXPECT_GE(outcome.ambiguous, kPairs - 1);
  EXPECT_LE(outcome.worst_ambiguous_quality, 20);
  EXPECT_LT(outcome.end_error_sigmas, 3.0) << "the covariance spans the wheels' motion";
}

// All that is seen stands still before the rig, while the wheels drive on from the first pair on.
TEST(EgomotionWheels, TheyContradictAMotionThatNothingIsKnownToRestFor) {
  World world(7, 500, 1.0);
  EgomotionEstimator estimator{EgomotionConfig{}};
  Egomotion motion;
  Wheels wheels;
  wheels.follow(resting(), world.tracks());
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < 5; ++k) {
    world.mover_velocity_m = world.T_first_current().linear() * walking().translation();
    world.step(walking(), kDtS);
    wheels.follow(walking(), world.tracks());
    estimator.estimate(world.tracks(), motion);
    ASSERT_EQ(motion.status, EstimateStatus::kAmbiguous) << k;
    EXPECT_EQ(motion.reason, EstimateReason::kWheelsContradict) << k;
    EXPECT_LE(motion.quality, 20) << k;
  }
}

TEST(EgomotionWheels, SlippingOnesChangeNothingWhereNothingElseMoves) {
  for (const double slip : {0.0, 0.1, 0.2}) {
    const auto drive = [slip](World&, int) { return Step{walking(), slipping(walking(), slip)}; };
    EgomotionConfig without;
    without.wheels.enable = false;
    const Outcome with = run(World(1, 500), drive);
    EXPECT_EQ(with.ambiguous, 0) << slip;
    EXPECT_EQ(with.end_error_m, run(World(1, 500), drive, without).end_error_m) << slip;
  }
}

void expect_unharmed(const Outcome& outcome) {
  EXPECT_EQ(outcome.dragged, 0);
  EXPECT_EQ(outcome.ambiguous, 0);
  EXPECT_LT(outcome.end_error_m, 2e-3);
}

TEST(EgomotionWheels, AnEncoderThatSticksDoesNoHarm) {
  expect_unharmed(run(World(2, 500), [](World&, int k) {
    return Step{walking(), k < kFaultComes ? walking() : resting()};
  }));
}

TEST(EgomotionWheels, AnEncoderThatSticksDoesNoHarmWhileSomebodyLeads) {
  const Outcome outcome = run(World(2, 500, 0.25), [](World& world, int k) {
    world.mover_velocity_m = world.T_first_current().linear() * walking().translation();
    return Step{walking(), k < kFaultComes ? walking() : resting()};
  });
  EXPECT_EQ(outcome.dragged, 0);
  EXPECT_LT(outcome.end_error_m, 5e-3);
}

TEST(EgomotionWheels, WheelsThatSpinUpOnALiftedRigDoNoHarm) {
  expect_unharmed(run(World(3, 500), [](World&, int k) {
    const double speed = std::clamp((k - kFaultComes) / 30.0, 0.0, 1.0);  // within what a base can
    return Step{resting(), se3_exp(speed * se3_log(walking()))};
  }));
}

TEST(EgomotionWheels, WheelsThatLoseTheirGripWhileDrivingDoNoHarm) {
  expect_unharmed(run(World(4, 500), [](World&, int k) {
    const double slip = 0.8 * std::clamp((k - kFaultComes) / 20.0, 0.0, 1.0);
    return Step{walking(), slipping(walking(), slip)};
  }));
}

TEST(EgomotionWheels, ABaseThatStartsCountingAnewMakesNoMotion) {
  World world(5, 500);
  EgomotionEstimator estimator{EgomotionConfig{}};
  Egomotion motion;
  Wheels wheels;
  wheels.follow(resting(), world.tracks());
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < 20; ++k) {
    world.step(walking(), kDtS);
    Vector6d jump = Vector6d::Zero();
    jump[2] = k == 10 ? 5.0 : 0.015;
    wheels.stretch = k < 10 ? 0 : 1;
    wheels.follow(se3_exp(jump), world.tracks());
    estimator.estimate(world.tracks(), motion);
    EXPECT_EQ(motion.status, EstimateStatus::kValid) << k;
  }
}

TEST(EgomotionWheels, TheirDoubtsAllocateNothing) {
  World world(6, 500, 0.8);
  EgomotionEstimator estimator{EgomotionConfig{}};
  Egomotion motion;
  Wheels wheels;
  wheels.follow(resting(), world.tracks());
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < 20; ++k) {
    world.mover_velocity_m = world.T_first_current().linear() * walking().translation();
    world.step(walking(), kDtS);
    wheels.follow(walking(), world.tracks());
    const long before = allocations();
    estimator.estimate(world.tracks(), motion);
    if (k > 5) {
      EXPECT_EQ(allocations(), before) << k;
    }
  }
}

}  // namespace
}  // namespace egomod
