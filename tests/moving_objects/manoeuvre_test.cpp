// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/manoeuvre.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>

namespace egomod {
namespace {

using namespace std::chrono_literals;

constexpr double kNothing = 1e-12;

BodyMotion body(const Eigen::Vector3d& velocity_mps) { return {.velocity_mps = velocity_mps}; }

TEST(Manoeuvre, AddsNothingToASteadyVelocity) {
  Manoeuvre manoeuvre;
  for (int k = 0; k < 30; ++k) manoeuvre.follow(body({0.4, 0.0, -0.1}), k * 33ms);
  EXPECT_LT(manoeuvre.lead_mps().norm(), kNothing);
  EXPECT_LT(manoeuvre.covariance_m2ps2().norm(), kNothing);
}

TEST(Manoeuvre, LeadsAVelocityThatGrowsAndOwnsUpToItsLag) {
  Manoeuvre manoeuvre;
  for (int k = 0; k < 60; ++k) manoeuvre.follow(body({0.0, 0.0, 0.03 * k}), k * 33ms);
  EXPECT_GT(manoeuvre.lead_mps().z(), 0.0);
  EXPECT_LT(manoeuvre.lead_mps().head<2>().norm(), kNothing);
  // A ramp of 0.91 m/s^2 is some 0.13 m/s behind after 0.15 s, which the steady lead makes good for
  // the most part.
  const Eigen::Matrix3d covariance = manoeuvre.covariance_m2ps2();
  EXPECT_NEAR(std::sqrt(covariance(2, 2)), 0.07, 0.02);
  // Less is wrong across it, but not nothing.
  EXPECT_GT(covariance(0, 0), 0.05 * covariance(2, 2));
  EXPECT_LT(covariance(0, 0), 0.2 * covariance(2, 2));
}

// Filters that follow a ramp of 0.9 m/s^2 stay some 0.13 m/s behind the mean of the last 0.15 s.
TEST(Manoeuvre, LeadsWhatGoesOnToGrowByAllThatItIsBehind) {
  Manoeuvre manoeuvre;
  for (int k = 0; k < 60; ++k) manoeuvre.follow(body({0.0, 0.0, 0.03 * k}), k * 33ms);
  EXPECT_NEAR(manoeuvre.steady_lead_mps().z(), 0.12, 0.02);
}

// A filter that lags far behind along the line of sight only shows a part of the change in 0.15 s.
TEST(Manoeuvre, LeadsByTheLagOfEachDirection) {
  Manoeuvre manoeuvre;
  for (int k = 0; k < 60; ++k) {
    BodyMotion slow = body({0.03 * k, 0.0, 0.03 * k});
    slow.lag_s.diagonal() = Eigen::Vector3d(0.05, 0.05, 0.6);
    manoeuvre.follow(slow, k * 33ms);
  }
  EXPECT_NEAR(manoeuvre.steady_lead_mps().x(), 0.12, 0.02);
  EXPECT_NEAR(manoeuvre.steady_lead_mps().z(), 0.48, 0.08);
  const Eigen::Matrix3d covariance = manoeuvre.covariance_m2ps2();
  EXPECT_GT(covariance(2, 2), 4.0 * covariance(0, 0)) << "the longer lead is the less sure one";
}

TEST(Manoeuvre, IsSurerOfWhatItLeads) {
  const auto sigma_mps = [](double noise_mps) {
    Manoeuvre manoeuvre;
    for (int k = 0; k < 60; ++k) {
      BodyMotion noisy = body({0.0, 0.0, 0.03 * k});
      noisy.velocity_covariance_m2ps2 = noise_mps * noise_mps * Eigen::Matrix3d::Identity();
      manoeuvre.follow(noisy, k * 33ms);
    }
    return std::sqrt(manoeuvre.covariance_m2ps2()(2, 2));
  };
  EXPECT_LT(sigma_mps(0.01), 0.7 * sigma_mps(0.2)) << "in so much noise it is not led";
}

TEST(Manoeuvre, IsNoSurerTheNoisierItIs) {
  double before = 0.0;
  for (const double noise_mps : {0.02, 0.05, 0.08, 0.12, 0.2, 0.3}) {
    Manoeuvre manoeuvre;
    for (int k = 0; k < 60; ++k) {
      BodyMotion far = body({0.0, 0.0, 0.01 * k});
      far.lag_s(2, 2) = 0.8;
      far.velocity_covariance_m2ps2 = noise_mps * noise_mps * Eigen::Matrix3d::Identity();
      manoeuvre.follow(far, k * 33ms);
    }
    const double own = manoeuvre.covariance_m2ps2()(2, 2) + noise_mps * noise_mps;
    EXPECT_GT(own, before) << noise_mps;
    before = own;
  }
}

// What filters have yet to learn of a velocity looks like a steady change.
TEST(Manoeuvre, DoesNotLeadWhatHasJustSetOff) {
  const auto lead_mps = [](double stood_share) {
    Manoeuvre manoeuvre;
    for (int k = 0; k < 20; ++k) {
      BodyMotion far = body({0.0, 0.0, 0.02 * k});
      far.lag_s(2, 2) = 0.8;
      manoeuvre.follow(far, k * 33ms, {.stood_share = stood_share});
    }
    return manoeuvre.steady_lead_mps().z();
  };
  EXPECT_GT(lead_mps(0.0), 0.1);
  EXPECT_LT(lead_mps(1.0), 0.25 * lead_mps(0.0));
}

TEST(Manoeuvre, LeadsAlikeInAnyAxes) {
  const auto lead_mps = [](double turn_rad) {
    const Eigen::Matrix3d R = Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitX()).matrix();
    Manoeuvre manoeuvre;
    for (int k = 0; k < 60; ++k)
      manoeuvre.follow(body(R * Eigen::Vector3d(0.0, 0.03 * std::sin(1.2 * k), 0.01 * k)),
                       k * 33ms);
    return manoeuvre.steady_lead_mps().norm();
  };
  EXPECT_GT(lead_mps(0.0), 0.01);
  EXPECT_NEAR(lead_mps(0.4), lead_mps(0.0), 1e-9);
}

TEST(Manoeuvre, DoesNotLeadWhatIsNoMoreThanNoise) {
  Manoeuvre manoeuvre;
  for (int k = 0; k < 60; ++k) {
    BodyMotion noisy = body({0.0, 0.0, 0.03 * k});
    noisy.velocity_covariance_m2ps2 = 0.04 * Eigen::Matrix3d::Identity();
    manoeuvre.follow(noisy, k * 33ms);
  }
  EXPECT_EQ(manoeuvre.steady_lead_mps().norm(), 0.0);
}

TEST(Manoeuvre, LeadsNothingOnThatWentBeforeAGap) {
  Manoeuvre manoeuvre;
  for (int k = 0; k < 30; ++k) manoeuvre.follow(body({0.0, 0.0, 1.0 - 0.03 * k}), k * 33ms);
  for (int k = 0; k < 10; ++k) {
    manoeuvre.follow(body({0.0, 0.0, 0.5}), 2s + k * 33ms);
    EXPECT_LT(manoeuvre.steady_lead_mps().norm(), kNothing) << k;
  }
}

TEST(Manoeuvre, DoesNotLeadWhatSwings) {
  Manoeuvre manoeuvre;
  for (int k = 0; k < 60; ++k) {
    manoeuvre.follow(body({0.0, 0.0, 0.4 * std::sin(1.2 * k)}), k * 33ms);
    EXPECT_LT(manoeuvre.steady_lead_mps().norm(), k < 10 ? 0.4 : 0.02) << k;
  }
}

TEST(Manoeuvre, CalmsDownAfterwards) {
  Manoeuvre manoeuvre;
  Nanoseconds now{0};
  for (int k = 0; k < 10; ++k) manoeuvre.follow(body({0.1 * k, 0.0, 0.0}), now += 33ms);
  const double then = manoeuvre.covariance_m2ps2()(0, 0);
  for (int k = 0; k < 60; ++k) manoeuvre.follow(body({0.9, 0.0, 0.0}), now += 33ms);
  EXPECT_LT(manoeuvre.covariance_m2ps2()(0, 0), 0.05 * then);
}

TEST(Manoeuvre, VelocityOfWhatStoodMayBeFarBehindAtFirst) {
  Manoeuvre manoeuvre;
  for (int k = 0; k < 16; ++k) {
    manoeuvre.follow(body({0.0, 0.0, 0.2}), k * 33ms, {.stood_share = 1.0});
    const double sigma_mps = std::sqrt(manoeuvre.covariance_m2ps2()(2, 2));
    if (k == 0) {
      EXPECT_GT(sigma_mps, 0.15);
    }
    if (k == 15) {
      EXPECT_LT(sigma_mps, 0.02);
    }
    EXPECT_LT(manoeuvre.lead_mps().norm(), kNothing);
  }
}

TEST(Manoeuvre, HasAPastThatMayKeepItBehindAfterARestOrAfterSomeTime) {
  Manoeuvre started;
  started.follow(body({0.4, 0.0, 0.0}), 0ms, {.stood_share = 1.0});
  EXPECT_TRUE(started.has_past());
  EXPECT_NEAR(started.behind_share(), 1.0, kNothing);
  started.follow(body({0.4, 0.0, 0.0}), 400ms);
  EXPECT_LT(started.behind_share(), 0.3);
  Manoeuvre found;
  found.follow(body({0.4, 0.0, 0.0}), 0ms, {.learnt_s = 0.2});
  EXPECT_FALSE(found.has_past());
  EXPECT_EQ(found.behind_share(), 0.0);
  found.follow(body({0.4, 0.0, 0.0}), 400ms);
  EXPECT_TRUE(found.has_past());
}

TEST(Manoeuvre, IsYoungForAboutAsLongAsItWasSought) {
  const auto youth_after = [](Nanoseconds age, double learnt_s) {
    Manoeuvre manoeuvre;
    manoeuvre.follow(body({0.4, 0.0, 0.0}), 0ms, {.learnt_s = learnt_s});
    manoeuvre.follow(body({0.4, 0.0, 0.0}), age, {});
    return manoeuvre.youth();
  };
  EXPECT_NEAR(youth_after(0ms, 0.4), 1.0, kNothing);
  EXPECT_LT(youth_after(400ms, 0.4), 0.2);
  EXPECT_GT(youth_after(100ms, 0.4), youth_after(100ms, 0.1));
}

TEST(Manoeuvre, StartsAnewAfterALongTimeUnseen) {
  Manoeuvre manoeuvre;
  manoeuvre.follow(body({0.4, 0.0, 0.0}), 0ms);
  manoeuvre.follow(body({-0.4, 0.0, 0.0}), 1000ms);
  EXPECT_LT(manoeuvre.lead_mps().norm(), kNothing);
  EXPECT_LT(manoeuvre.covariance_m2ps2().norm(), kNothing);
}

TEST(Manoeuvre, TurnsWithTheCamera) {
  Manoeuvre manoeuvre;
  for (int k = 0; k < 10; ++k) manoeuvre.follow(body({0.1 * k, 0.0, 0.0}), k * 33ms);
  const double lead_mps = manoeuvre.lead_mps().x();
  Eigen::Matrix3d quarter;
  quarter << 0, 0, 1, 0, 1, 0, -1, 0, 0;  // x to -z
  manoeuvre.rotate(quarter);
  EXPECT_NEAR(manoeuvre.lead_mps().z(), -lead_mps, kNothing);
  EXPECT_GT(manoeuvre.covariance_m2ps2()(2, 2), 5.0 * manoeuvre.covariance_m2ps2()(0, 0));
}

}  // namespace
}  // namespace egomod
