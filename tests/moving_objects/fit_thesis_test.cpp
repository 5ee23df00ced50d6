// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "fit_fixture.hpp"
#include "labels.hpp"
#include "thesis_model.hpp"

namespace egomod::fit {
namespace {

using ::testing::HasSubstr;

class FitThesis : public FitFolder {
 protected:
  Options options_of(const Labels& labels) const {
    write_labels(folder / "labels.csv", labels);
    Options options;
    options.labels = folder / "labels.csv";
    options.output = folder;
    options.plot = false;
    return options;
  }
};

std::vector<double> rayleigh_samples(double sigma_mps, int count) {
  std::mt19937 generator(11);
  std::normal_distribution<double> normal(0.0, sigma_mps);
  std::vector<double> speeds_mps;
  for (int i = 0; i < count; ++i)
    speeds_mps.push_back(std::hypot(normal(generator), normal(generator)));
  return speeds_mps;
}

TEST_F(FitThesis, FindsTheScalesThatTheSamplesHave) {
  const FitResult fit =
      fit_thesis(options_of({rayleigh_samples(0.1, 20'000), rayleigh_samples(0.4, 20'000)}));
  ASSERT_EQ(fit.keys.size(), 4U);
  EXPECT_EQ(fit.keys[1].name, "sigma_static_mps");
  EXPECT_NEAR(fit.keys[1].value, 0.1, 0.002);
  EXPECT_NEAR(fit.keys[2].value, 0.4, 0.008);
  // Where both densities are equal: s^2 = 2 ln(m^2 / s^2) / (1 / s^2 - 1 / m^2).
  EXPECT_NEAR(fit.keys[0].value, std::sqrt(2.0 * std::log(16.0) / (100.0 - 6.25)), 0.005);
  EXPECT_EQ(fit.keys[3].value, 0.5);
}

TEST_F(FitThesis, SpeedsThatAreAll0AreRefusedWithTheRemedy) {
  try {
    (void)fit_thesis(options_of({{0.0, 0.0}, {0.5, 1.0}}));
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("static samples are all but 0"));
    EXPECT_THAT(error.what(), HasSubstr("label speeds as measured"));
  }
}

}  // namespace
}  // namespace egomod::fit
