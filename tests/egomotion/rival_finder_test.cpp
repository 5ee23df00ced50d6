// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/rival_finder.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace egomod
