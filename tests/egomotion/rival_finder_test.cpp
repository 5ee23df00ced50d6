// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/rival_finder.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <random>

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
TEST(RivalFinderOfFewPoints, WhatBothExplainTellsTheRivalExactly) {
  constexpr double kInterval_s = 1.0 / 30.0;
  const Eigen::Isometry3d T_rig =
      motion_of((Vector6d() << 0, 0, 0.8, 0, -0.18, 0).finished(), kInterval_s);
  const Eigen::Vector3d mover_step_m{0.012, 0.0, 0.008};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  TrackSet tracks;
  tracks.camera = synthetic::kCamera;
  tracks.sequence = 7;
  const auto seen_at = [](double u_px, double v_px, double z_m) -> Eigen::Vector3d {
    const StereoCamera& c = synthetic::kCamera;
    return {(u_px - c.cx_px) * z_m / c.fx_px, (v_px - c.cy_px) * z_m / c.fy_px, z_m};
  };
  const auto add = [&](int count, const synthetic::Noise& noise, const Eigen::Vector3d& step_m,
                       const std::function<Eigen::Vector3d()>& place) {
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector3d P_m = place();
      Track track;
      track.id = tracks.tracks.size() + 1;
      track.has_current = track.has_previous = true;
      track.previous = synthetic::observe(P_m, noise, random);
      track.current = synthetic::observe(T_rig.inverse() * (P_m + step_m), noise, random);
      tracks.tracks.push_back(track);
    }
  };
  constexpr int kOfMover = 130;
  constexpr int kOfWall = 350;
  const synthetic::Noise fine{.u_px = 0.05, .v_px = 0.05, .disparity_px = 0.1};
  const synthetic::Noise coarse{.u_px = 0.4, .v_px = 0.4, .disparity_px = 0.6};
  add(kOfMover, fine, mover_step_m, [&] {
    return seen_at(270 + 100 * unit(random), 200 + 150 * unit(random), 3.2 + 0.3 * unit(random));
  });
  add(kOfWall, fine, Eigen::Vector3d::Zero(),
      [&] { return seen_at(640 * unit(random), 60 + 200 * unit(random), 11.5 + unit(random)); });
  add(40, coarse, Eigen::Vector3d::Zero(), [&] {
    const double v_px = 120 * unit(random);
    return seen_at(640 * unit(random), v_px < 60 ? v_px : 300 + v_px, 1.5 + 2.0 * unit(random));
  });

  // What most agree on, as an estimate that has been dragged along would have it.
  const EgomotionConfig config;
  std::vector<Correspondence> agreeing;
  for (std::size_t k = 0; k < kOfMover + kOfWall; ++k) {
    Correspondence c;
    ASSERT_TRUE(correspondence_of(tracks.camera, uvd(tracks.tracks[k].previous),
                                  covariance(tracks.tracks[k].previous), c));
    c.track = k;
    c.observed_px = uvd(tracks.tracks[k].current);
    c.covariance_observed_px2 = covariance(tracks.tracks[k].current);
    agreeing.push_back(c);
  }
  GaussNewtonSolver solver(config.gauss_newton, config.ransac);
  const Eigen::Isometry3d T_dragged{Eigen::Translation3d(-mover_step_m) * T_rig};
  const Solution estimate = solver.solve_near(tracks.camera, agreeing, T_dragged);
  ASSERT_EQ(estimate.failure, EstimateReason::kNone);
  const auto error_m = [&](const Solution& s) {
    return (s.T_previous_current.translation() - T_rig.translation()).norm();
  };
  ASSERT_GT(error_m(estimate), 0.01);

  std::vector<TrackRole> roles(tracks.tracks.size(), TrackRole::kInlier);
  std::fill(roles.begin() + kOfMover + kOfWall, roles.end(), TrackRole::kOutlier);
  RivalFinder finder(config.rival, config.gauss_newton, config.ransac);
  Rival rival;
  const VelocityState past{.y = velocity_of(estimate.T_previous_current, kInterval_s)};
  static_cast<void>(
      finder.find(tracks, estimate, roles, {}, 1.0, {.past = past, .dt_s = kInterval_s}, rival));
  EXPECT_LT(error_m(rival.solution), 0.0015);
}

}  // namespace
}  // namespace egomod
