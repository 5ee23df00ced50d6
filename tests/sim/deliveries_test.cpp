// SPDX-License-Identifier: Apache-2.0
#include "deliveries.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace egomod::sim {
namespace {

World world(double duration_s) {
  World world;
  world.duration_s = duration_s;
  world.rate_hz = 10.0;
  return world;
}

std::vector<Delivery> all(const World& world) {
  Deliveries deliveries(world);
  std::vector<Delivery> out;
  while (const auto next = deliveries.next()) out.push_back(*next);
  return out;
}

TEST(Deliveries, AreOnePairAfterTheOtherWhereBothCamerasAreIdeal) {
  const auto out = all(world(0.5));
  ASSERT_EQ(out.size(), 5U);
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_TRUE(out[i].is_pair);
    EXPECT_EQ(out[i].exposure.number, i);
  }
}

TEST(Deliveries, AreWhatEachCameraDeliversInOrderOfArrival) {
  World real = world(20.0);
  real.timing = {.jitter_s = 0.002,
                 .right_offset_s = 0.03,
                 .right_drift_ppm = 200.0,
                 .drop_probability = 0.1,
                 .late_probability = 0.2,
                 .late_s = 0.25};
  const auto out = all(real);
  const auto by_arrival = [](const Delivery& a, const Delivery& b) {
    return a.arrival_s() < b.arrival_s();
  };
  EXPECT_TRUE(std::is_sorted(out.begin(), out.end(), by_arrival));
  for (const Eye eye : {Eye::kLeft, Eye::kRight}) {
    const auto expected = delivered(real, eye);
    std::vector<std::uint64_t> indices;
    for (const Delivery& one : out) {
      EXPECT_FALSE(one.is_pair);
      if (one.eye != eye) continue;
      indices.push_back(one.index);
      EXPECT_EQ(one.exposure.number, expected.at(one.index).number);
    }
    EXPECT_FALSE(std::is_sorted(indices.begin(), indices.end())) << "none was overtaken";
    EXPECT_EQ(std::set(indices.begin(), indices.end()).size(), expected.size());
  }
}

TEST(Deliveries, HaveNoEndWhereTheWorldHasNone) {
  const World endless = world(0.0);
  Deliveries deliveries(endless);
  for (std::uint64_t i = 0; i < 1000; ++i) ASSERT_EQ(deliveries.next()->exposure.number, i);
}

}  // namespace
}  // namespace egomod::sim
