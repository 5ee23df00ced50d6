// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/grouping.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace egomod {
namespace {

using ::testing::ElementsAre;

void group_by_distance(Grouper& grouper, const std::vector<double>& x, double reach) {
  grouper.group(
      x.size(), reach, [&](auto i) { return x[i]; },
      [&](auto i, auto j) { return std::abs(x[i] - x[j]) <= reach; });
}

TEST(Grouper, ChainsNeighboursAndKeepsTheRestApart) {
  Grouper grouper;
  group_by_distance(grouper, {5.0, 0.0, 0.9, 1.8, 5.5}, 1.0);
  ASSERT_EQ(grouper.size(), 2U);
  EXPECT_THAT(grouper[0], ElementsAre(0, 4));
  EXPECT_THAT(grouper[1], ElementsAre(1, 2, 3));
}

TEST(Grouper, NothingMakesNoGroup) {
  Grouper grouper;
  group_by_distance(grouper, {}, 1.0);
  EXPECT_EQ(grouper.size(), 0U);
}

TEST(Grouper, AgreesWithTestingEveryPair) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 60.0);
  std::vector<double> x(200);
  for (double& value : x) value = uniform(random);
  Grouper grouper;
  group_by_distance(grouper, x, 0.4);
  std::vector<double> sorted = x;
  std::sort(sorted.begin(), sorted.end());
  std::size_t expected = 1;
  for (std::size_t i = 1; i < sorted.size(); ++i) expected += sorted[i] - sorted[i - 1] > 0.4;
  EXPECT_EQ(grouper.size(), expected);
}

}  // namespace
}  // namespace egomod
