// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/rival_finder.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "../moving_objects/counted_new.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomotion_fixture.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {
namespace {

// The rig's motion is known; half of the tracks move on their own.
class RivalFinderTest : public testing::Test {
 protected:
  static constexpr double kInterval_s = 0.1;

  explicit RivalFinderTest(const Eigen::Vector3d& mover_velocity_m = {0.006, 0.0, 0.002}) {
    world_.mover_velocity_m = mover_velocity_m;  // a pair
    tracks_ = world_.step(forward_and_left());
    for (std::size_t k = 0; k < tracks_.tracks.size(); ++k) {
      const bool moves = world_.is_mover(k);
      roles_.push_back(moves ? TrackRole::kOutlier : TrackRole::kInlier);
      map_.push_back({.track_id = tracks_.tracks[k].id, .updates = 20});
      movers_given_up_.push_back(map_.back());
      if (moves) movers_given_up_.back().static_weight = 0.1;
    }
    all_agree_.assign(roles_.size(), TrackRole::kInlier);
  }

  bool find(const std::vector<TrackRole>& roles, const std::vector<MapPoint>& map,
            double interval_s = kInterval_s) {
    const VelocityState past{.y = velocity_of(forward_and_left(), kInterval_s)};
    const Solution estimate{.T_previous_current = motion_of(past.y, interval_s),
                            .covariance = 1e-6 * Matrix6d::Identity()};
    return finder_.find(tracks_, estimate, roles, map, 1.0, {.past = past, .dt_s = interval_s},
                        rival_);
  }

  synthetic::World world_{5, 600, 0.5};
  TrackSet tracks_;
  std::vector<TrackRole> roles_;
  std::vector<TrackRole> all_agree_;
  std::vector<MapPoint> map_;
  std::vector<MapPoint> movers_given_up_;
  EgomotionConfig config_;
  RivalFinder finder_{config_.rival, config_.gauss_newton, config_.ransac};
  Rival rival_;
};

TEST_F(RivalFinderTest, FindsTheMotionOfHalfOfTheTracks) { EXPECT_TRUE(find(roles_, map_)); }

TEST_F(RivalFinderTest, FindsNoneWhereAllAgree) {
  EXPECT_FALSE(find(all_agree_, map_));
  EXPECT_FALSE(find(all_agree_, movers_given_up_)) << "none was found before";
}

TEST_F(RivalFinderTest, StaysInDoubtWhileTheMapHasGivenUpHalfOfTheImage) {
  ASSERT_TRUE(find(roles_, map_));
  const Eigen::Isometry3d T_rival = rival_.solution.T_previous_current;
  for (int pair = 0; pair < 3; ++pair) {
    rival_ = {};
    ASSERT_TRUE(find(all_agree_, movers_given_up_));
    EXPECT_TRUE(rival_.solution.T_previous_current.isApprox(T_rival));
    EXPECT_FALSE(rival_.preferred);
  }
  EXPECT_FALSE(find(all_agree_, map_)) << "the map owns all again";
}

class RivalFinderOnFastMover : public RivalFinderTest {
 protected:
  RivalFinderOnFastMover() : RivalFinderTest({0.15, 0.0, 0.05}) {}
};

// The map has not trusted those points again, but none moves as the rival did.
TEST_F(RivalFinderOnFastMover, DoubtEndsWithAPairThatWouldShowIt) {
  ASSERT_TRUE(find(roles_, map_));
  EXPECT_FALSE(find(all_agree_, movers_given_up_));
}

TEST_F(RivalFinderTest, TheRivalGoesOnAtItsVelocityWhateverTheInterval) {
  ASSERT_TRUE(find(roles_, map_));
  const Eigen::Isometry3d T_rival = rival_.solution.T_previous_current;
  ASSERT_TRUE(find(all_agree_, movers_given_up_, 2.0 * kInterval_s));
  const Eigen::Isometry3d& T_doubled = rival_.solution.T_previous_current;
  EXPECT_TRUE(T_doubled.translation().isApprox(2.0 * T_rival.translation()));
  EXPECT_TRUE(T_doubled.linear().isApprox(T_rival.linear() * T_rival.linear()));
}

TEST_F(RivalFinderTest, DoubtEndsWithAReset) {
  ASSERT_TRUE(find(roles_, map_));
  finder_.reset();
  EXPECT_FALSE(find(all_agree_, movers_given_up_));
}

// A near mover and a far wall agree on a motion, since a turn does for the wall what a step to the
// side would do; only a few points of floor and ceiling, which are seen badly, tell the rig's.
class RivalFinderOfFewPoints : public testing::Test {
 protected:
  static constexpr double kInterval_s = 1.0 / 30.0;
  static constexpr int kOfMover = 130;
  static constexpr int kOfWall = 350;
  static constexpr int kFew = 40;
  static constexpr double kExact_m = 0.0015;

  RivalFinderOfFewPoints() {
    tracks_.camera = synthetic::kCamera;
    tracks_.sequence = 7;
    add(kOfMover, fine_, mover_step_m_,
        [&] { return seen_at(270 + 100 * share(), 200 + 150 * share(), 3.2 + 0.3 * share()); });
    add(kOfWall, fine_, Eigen::Vector3d::Zero(),
        [&] { return seen_at(640 * share(), 60 + 200 * share(), 11.5 + share()); });
  }

  void show_floor_and_ceiling() {
    add(kFew, coarse_, Eigen::Vector3d::Zero(), [&] {
      const double v_px = 120 * share();
      return seen_at(640 * share(), v_px < 60 ? v_px : 300 + v_px, 1.5 + 2.0 * share());
    });
  }
  void show_one_place() {
    add(kFew, coarse_, Eigen::Vector3d::Zero(),
        [&] { return seen_at(40 + 160 * share(), 330 + 120 * share(), 1.5 + 2.0 * share()); });
  }

  // What most agree on, as an estimate that has been dragged along would have it.
  [[nodiscard]] Solution dragged() const {
    std::vector<Correspondence> agreeing;
    for (std::size_t k = 0; k < kOfMover + kOfWall; ++k) {
      Correspondence c;
      EXPECT_TRUE(correspondence_of(tracks_.camera, uvd(tracks_.tracks[k].previous),
                                    covariance(tracks_.tracks[k].previous), c));
      c.track = k;
      c.observed_px = uvd(tracks_.tracks[k].current);
      c.covariance_observed_px2 = covariance(tracks_.tracks[k].current);
      agreeing.push_back(c);
    }
    GaussNewtonSolver solver(config_.gauss_newton, config_.ransac);
    const Eigen::Isometry3d T_dragged{Eigen::Translation3d(-mover_step_m_) * T_rig_};
    return solver.solve_near(tracks_.camera, agreeing, T_dragged);
  }

  bool find(const WheelsMotion* wheels = nullptr) {
    std::vector<TrackRole> roles = all_agree();
    std::fill(roles.begin() + kOfMover + kOfWall, roles.end(), TrackRole::kOutlier);
    return find_among(roles, wheels);
  }
  bool find_among(const std::vector<TrackRole>& roles, const WheelsMotion* wheels = nullptr) {
    const Solution estimate = dragged();
    EXPECT_GT(error_m(estimate), 0.01);
    const VelocityState past{.y = velocity_of(estimate.T_previous_current, kInterval_s)};
    const long before = allocations();
    const bool found = finder_.find(tracks_, estimate, roles, {}, 1.0,
                                    {.past = past, .dt_s = kInterval_s, .wheels = wheels}, rival_);
    allocated_ = allocations() - before;
    return found;
  }
  [[nodiscard]] std::vector<TrackRole> all_agree() const {
    return std::vector<TrackRole>(tracks_.tracks.size(), TrackRole::kInlier);
  }

  [[nodiscard]] double error_m(const Solution& s) const {
    return (s.T_previous_current.translation() - T_rig_.translation()).norm();
  }

  const Eigen::Isometry3d T_rig_ =
      motion_of((Vector6d() << 0, 0, 0.8, 0, -0.18, 0).finished(), kInterval_s);
  EgomotionConfig config_;
  RivalFinder finder_{config_.rival, config_.gauss_newton, config_.ransac};
  Rival rival_;
  long allocated_ = 0;  // by the last pair

 private:
  double share() { return std::uniform_real_distribution<double>(0.0, 1.0)(random_); }

  static Eigen::Vector3d seen_at(double u_px, double v_px, double z_m) {
    const StereoCamera& c = synthetic::kCamera;
    return {(u_px - c.cx_px) * z_m / c.fx_px, (v_px - c.cy_px) * z_m / c.fy_px, z_m};
  }

  void add(int count, const synthetic::Noise& noise, const Eigen::Vector3d& step_m,
           const std::function<Eigen::Vector3d()>& place) {
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector3d P_m = place();
      Track track;
      track.id = tracks_.tracks.size() + 1;
      track.has_current = track.has_previous = true;
      track.previous = synthetic::observe(P_m, noise, random_);
      track.current = synthetic::observe(T_rig_.inverse() * (P_m + step_m), noise, random_);
      tracks_.tracks.push_back(track);
    }
  }

  const Eigen::Vector3d mover_step_m_{0.012, 0.0, 0.008};
  const synthetic::Noise fine_{.u_px = 0.05, .v_px = 0.05, .disparity_px = 0.1};
  const synthetic::Noise coarse_{.u_px = 0.4, .v_px = 0.4, .disparity_px = 0.6};
  std::mt19937 random_{3};
  TrackSet tracks_;
};

// By themselves the few points tell it to 3 mm.
TEST_F(RivalFinderOfFewPoints, WhatBothExplainTellsTheRivalExactly) {
  show_floor_and_ceiling();
  EXPECT_TRUE(find());
  EXPECT_LT(error_m(rival_.solution), kExact_m);
}

TEST_F(RivalFinderOfFewPoints, TheirComingAllocatesNothing) {
  show_floor_and_ceiling();
  ASSERT_FALSE(find_among(all_agree()));
  EXPECT_TRUE(find());
  EXPECT_LT(error_m(rival_.solution), kExact_m);
  EXPECT_EQ(allocated_, 0);
}

// They may be a mover's, and what is far would drag its motion to the rig's.
TEST_F(RivalFinderOfFewPoints, FewPointsInOnePlaceAreLeftAsTheyAre) {
  show_one_place();
  static_cast<void>(find());
  EXPECT_GT(error_m(rival_.solution), 10.0 * kExact_m);
}

TEST_F(RivalFinderOfFewPoints, ARivalThatIsKnownIsNotRefinedAgain) {
  show_floor_and_ceiling();
  ASSERT_TRUE(find());
  EXPECT_TRUE(find());
  EXPECT_GT(error_m(rival_.solution), kExact_m);
}

TEST_F(RivalFinderOfFewPoints, AMotionThatTheWheelsConfirmIsLeftAsItIs) {
  show_floor_and_ceiling();
  const WheelsMotion wheels{T_rig_, 1e-6 * Matrix6d::Identity()};
  EXPECT_TRUE(find(&wheels));
  EXPECT_GT(error_m(rival_.solution), kExact_m);
}

}  // namespace
}  // namespace egomod
