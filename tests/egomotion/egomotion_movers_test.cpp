// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../moving_objects/counted_new.hpp"
#include "egomotion_fixture.hpp"

namespace egomod {
namespace {

using synthetic::World;

class EgomotionMoversTest : public EgomotionTest {};
INSTANTIATE_TEST_SUITE_P(Variants, EgomotionMoversTest, all_variants(), variant_name);

TEST_P(EgomotionMoversTest, MoversAndMismatchesDoNotDrag) {
  double worst_clean = 0.0;
  for (const bool dirty : {false, true}) {
    World world(5, 600, dirty ? 0.35 : 0.0, dirty ? 0.05 : 0.0);
    EgomotionEstimator estimator(config());
    Egomotion motion;
    estimator.estimate(world.tracks(), motion);
    double worst = 0.0;
    for (int k = 0; k < 30; ++k) {
      estimator.estimate(world.step(forward_and_left()), motion);
      ASSERT_EQ(motion.status, EstimateStatus::kValid);
      worst = std::max(worst, error_of(motion, forward_and_left()).head<3>().norm());
    }
    if (!dirty) worst_clean = worst;
    EXPECT_LT(worst, dirty ? 3 * worst_clean : 0.02);
  }
}

TEST_P(EgomotionMoversTest, RolesPartMoversFromTheRest) {
  World world(6, 600, 0.3);
  EgomotionEstimator estimator(config());
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  estimator.estimate(world.step(forward_and_left()), motion);
  int wrong = 0;
  int used = 0;
  for (std::size_t k = 0; k < motion.roles.size(); ++k) {
    if (motion.roles[k] == TrackRole::kUnused) continue;
    ++used;
    // The far ones of the movers hide in the noise.
    wrong += (motion.roles[k] == TrackRole::kOutlier) != world.is_mover(k) ? 1 : 0;
  }
  EXPECT_GT(used, 450);
  EXPECT_LT(wrong, used / 12);
}

constexpr double kDtS = 1.0 / 30.0;
constexpr int kPairs = 60;
constexpr int kMoverComes = 20;
constexpr std::uint32_t kSeeds = 3;
constexpr double kDraggedM = 0.01;  // in one pair; the mover makes 0.02

struct Outcome {
  int ambiguous = 0;
  int dragged = 0;           // pairs that took the mover's motion for the rig's
  int dragged_silently = 0;  // of them, called valid
  int last_dragged = -1;
  int worst_ambiguous_quality = 0;
  double end_error_m = 0.0;
  double end_error_sigmas = 0.0;
};

// `move(world, k)` prepares the world for its k-th step and returns the rig's motion.
template <typename Move>
Outcome run(World&& world, const Move& move) {
  EgomotionEstimator estimator{EgomotionConfig{}};
  Egomotion motion;
  Outcome outcome;
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < kPairs; ++k) {
    const Eigen::Isometry3d T = move(world, k);
    estimator.estimate(world.step(T, kDtS), motion);
    const bool ambiguous = motion.status == EstimateStatus::kAmbiguous;
    const bool dragged = error_of(motion, T).head<3>().norm() > kDraggedM;
    outcome.ambiguous += ambiguous ? 1 : 0;
    outcome.dragged += dragged ? 1 : 0;
    if (dragged) outcome.last_dragged = k;
    outcome.dragged_silently += dragged && !ambiguous ? 1 : 0;
    if (ambiguous)
      outcome.worst_ambiguous_quality = std::max(outcome.worst_ambiguous_quality, motion.quality);
    EXPECT_EQ(motion.reason == EstimateReason::kMoverDominates, ambiguous);
  }
  const Vector6d e = se3_log(motion.T_first_current.inverse() * world.T_first_current());
  outcome.end_error_m = e.head<3>().norm();
  outcome.end_error_sigmas = std::sqrt(e.dot(motion.covariance_first_current.ldlt().solve(e)));
  return outcome;
}

World world_with(std::uint32_t seed, double mover_share) {
  World world(seed, 500, mover_share);
  world.mover_velocity_m = {0.02, 0.0, 0.007};
  return world;
}

Eigen::Isometry3d walking() {
  Vector6d xi;
  xi << 0.003, 0.0, 0.015, 0.0, -0.008, 0.0;
  return se3_exp(xi);
}

Outcome run_with_mover_from_the_start(std::uint32_t seed, double share) {
  return run(world_with(seed, share), [](World&, int) { return walking(); });
}

Outcome run_with_mover_later(std::uint32_t seed, double share, const Eigen::Isometry3d& rig) {
  return run(world_with(seed, 0.0), [&](World& world, int k) {
    if (k == kMoverComes) world.let_mover_in(share);
    return rig;
  });
}

TEST(EgomotionMovers, UpToFortyPercentFromTheStartNeverDragTheRig) {
  for (const double share : {0.2, 0.4}) {
    double with = 0.0;
    double without = 0.0;
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
      const Outcome outcome = run_with_mover_from_the_start(seed, share);
      EXPECT_EQ(outcome.dragged, 0) << share << ' ' << seed;
      with += outcome.end_error_m;
      without += run_with_mover_from_the_start(seed, 0.0).end_error_m;
    }
    // Four ends are few: the ratio of their errors scatters by a factor of 1.5.
    EXPECT_LT(with, 3.0 * without) << share;
  }
}

TEST(EgomotionMovers, AFifthOfTheTracksIsNotAmbiguous) {
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed)
    EXPECT_EQ(run_with_mover_from_the_start(seed, 0.2).ambiguous, 0) << seed;
}

TEST(EgomotionMovers, HalfAndMoreFromTheStartAreAmbiguousWhoeverIsTakenForTheWorld) {
  for (const double share : {0.5, 0.6})
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
      const Outcome outcome = run_with_mover_from_the_start(seed, share);
      EXPECT_EQ(outcome.ambiguous, kPairs) << share << ' ' << seed;
      EXPECT_EQ(outcome.dragged_silently, 0) << share << ' ' << seed;
      EXPECT_GT(outcome.worst_ambiguous_quality, 0);
      EXPECT_LE(outcome.worst_ambiguous_quality, 20);
    }
}

TEST(EgomotionMovers, TracksLongStaticHoldAgainstAMoverThatComesLater) {
  for (const double share : {0.2, 0.4, 0.5, 0.6})
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed)
      for (const Eigen::Isometry3d& rig : {walking(), Eigen::Isometry3d::Identity()}) {
        const Outcome outcome = run_with_mover_later(seed, share, rig);
        EXPECT_EQ(outcome.dragged, 0) << share << ' ' << seed;
        EXPECT_LT(outcome.end_error_m, 1e-3) << share << ' ' << seed;
        if (share >= 0.5) {
          EXPECT_GE(outcome.ambiguous, kPairs - kMoverComes - 2) << share << ' ' << seed;
        }
        if (share <= 0.2) {
          EXPECT_EQ(outcome.ambiguous, 0);
        }
      }
}

TEST(EgomotionMovers, OneThatStartsFromRestDoesNotPullARestingRigAlong) {
  for (const double share : {0.2, 0.4, 0.5, 0.6})
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
      const Outcome outcome = run(world_with(seed, share), [](World& world, int k) {
        const double speed = std::clamp((k - kMoverComes) / 15.0, 0.0, 1.0);
        world.mover_velocity_m = speed * Eigen::Vector3d(0.02, 0.0, 0.007);
        return Eigen::Isometry3d::Identity();
      });
      EXPECT_EQ(outcome.dragged, 0) << share << ' ' << seed;
      EXPECT_LT(outcome.end_error_m, share <= 0.4 ? 1e-3 : 0.05) << share << ' ' << seed;
    }
}

TEST(EgomotionMovers, OneThatLeadsAtTheRigsSpeedIsNotTakenForTheWorldInSilence) {
  for (const double share : {0.2, 0.4, 0.5})
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
      const Outcome outcome = run(world_with(seed, share), [](World& world, int) {
        world.mover_velocity_m = world.T_first_current().linear() * walking().translation();
        return walking();
      });
      EXPECT_LE(outcome.dragged_silently, 1) << share << ' ' << seed;
      if (share <= 0.4) {
        EXPECT_LT(outcome.end_error_m, 2e-3) << share << ' ' << seed;
      }
    }
}

// What is in the middle of the image leads at the rig's speed from the first pair on.
Outcome run_behind(std::uint32_t seed, const synthetic::Middle& middle) {
  return run(World(seed, 500, middle), [](World& world, int) {
    world.mover_velocity_m = world.T_first_current().linear() * walking().translation();
    return walking();
  });
}

// In the first pair a slow one has hardly moved, and pulls: the map must not keep that.
TEST(EgomotionMovers, ASlowOneFromTheFirstPairOnLeavesNoLastingError) {
  constexpr std::uint32_t kManySeeds = 12;
  Vector6d xi = Vector6d::Zero();
  xi[2] = 0.2 * kDtS;
  const auto mean_error_m = [&](double share) {
    double sum = 0.0;
    for (std::uint32_t seed = 0; seed < kManySeeds; ++seed) {
      World world = world_with(seed, share);
      world.mover_velocity_m = xi.head<3>();
      sum += run(std::move(world), [&](World&, int) { return se3_exp(xi); }).end_error_m;
    }
    return sum / kManySeeds;
  };
  EXPECT_LT(mean_error_m(0.15), 1.5 * mean_error_m(0.0));
}

TEST(EgomotionMovers, ACrateThatHasAlwaysLedIsSoonKnownByTheRoomAroundIt) {
  constexpr int kSoon = 20;
  for (const double share : {0.4, 0.6})
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
      const Outcome outcome = run_behind(seed, {.side = std::sqrt(share)});
      EXPECT_LT(outcome.last_dragged, kSoon) << share << ' ' << seed;
      EXPECT_LE(outcome.dragged_silently, 3) << share << ' ' << seed;
      EXPECT_LT(outcome.end_error_sigmas, 6.0) << share << ' ' << seed;
    }
}

TEST(EgomotionMovers, OneBehindADoorIsNotTakenForTheWorldAlthoughItIsFartherThanTheWall) {
  const synthetic::Middle door{.side = std::sqrt(0.4), .depth_m = 4.0, .depth_around_m = 1.6};
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    const Outcome outcome = run_behind(seed, door);
    EXPECT_EQ(outcome.dragged, 0) << seed;
    EXPECT_LT(outcome.end_error_m, 2e-3) << seed;
  }
}

TEST(EgomotionMovers, TheirComingAllocatesNothing) {
  World world = world_with(1, 0.0);
  EgomotionEstimator estimator{EgomotionConfig{}};
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < 5; ++k) estimator.estimate(world.step(walking(), kDtS), motion);
  world.let_mover_in(0.5);
  for (int k = 0; k < 3; ++k) {
    const TrackSet& tracks = world.step(walking(), kDtS);
    const long before = allocations();
    estimator.estimate(tracks, motion);
    EXPECT_EQ(allocations(), before);
  }
  EXPECT_EQ(motion.status, EstimateStatus::kAmbiguous);
}

TEST(EgomotionMovers, ADoubtOutlastsAPairInWhichNothingIsSeen) {
  World world = world_with(1, 0.0);
  EgomotionEstimator estimator{EgomotionConfig{}};
  Egomotion motion;
  estimator.estimate(world.tracks(), motion);
  for (int k = 0; k < kMoverComes; ++k) estimator.estimate(world.step(walking(), kDtS), motion);
  world.let_mover_in(0.5);
  for (int k = 0; k < 5; ++k) estimator.estimate(world.step(walking(), kDtS), motion);
  ASSERT_EQ(motion.status, EstimateStatus::kAmbiguous);
  TrackSet blind = world.step(walking(), kDtS);
  for (Track& track : blind.tracks) track.has_current = false;
  estimator.estimate(blind, motion);
  ASSERT_EQ(motion.status, EstimateStatus::kFailed);
  for (int k = 0; k < 2; ++k) {
    estimator.estimate(world.step(walking(), kDtS), motion);
    EXPECT_EQ(motion.status, EstimateStatus::kAmbiguous) << k;
    EXPECT_LE(motion.quality, 20) << k;
  }
}

TEST(EgomotionMovers, TheCovarianceSpansTheOtherMotion) {
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed)
    EXPECT_LT(run_with_mover_from_the_start(seed, 0.6).end_error_sigmas, 6.0) << seed;
}

}  // namespace
}  // namespace egomod
