// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "labels.hpp"
#include "preset.hpp"

namespace egomod::fit {
namespace {

TEST(FitPreset, ReplacesFittedKeysAndKeepsAllElseToTheLetter) {
  const std::string text =
      "# why\n[capture]\nprior_moving = 7 # of another table\n\n[moving_objects] # it\n"
      "# prior_moving = 1\nprior_moving=0.5    # published\nmethod = \"thesis\"\n\n[publish]\n"
      "tracks = true\n";
  std::string changes;
  EXPECT_EQ(with_keys(text, {{"prior_moving", 0.25}, {"threshold_mps", 0.123456789}}, changes),
            "# why\n[capture]\nprior_moving = 7 # of another table\n\n[moving_objects] # it\n"
            "# prior_moving = 1\nprior_moving = 0.25  # fitted by egomod-fit\nmethod = \"thesis\"\n"
            "threshold_mps = 0.123457  # fitted by egomod-fit\n\n[publish]\ntracks = true\n");
  EXPECT_EQ(changes,
            "prior_moving         0.25  (was 0.5)\nthreshold_mps        0.123457  (was not set)\n");
}

TEST(FitPreset, GetsATableWhereThereIsNone) {
  std::string changes;
  EXPECT_EQ(with_keys("", {{"a", 1.0}}, changes),
            "[moving_objects]\na = 1  # fitted by egomod-fit\n");
  EXPECT_EQ(with_keys("[capture]\nb = 2", {{"a", 1.0}}, changes),
            "[capture]\nb = 2\n\n[moving_objects]\na = 1  # fitted by egomod-fit\n");
}

TEST(FitPreset, RefusesSpellingsThatWouldSetAKeyTwice) {
  const auto refit = [](const std::string& text) {
    std::string changes;
    static_cast<void>(with_keys(text, {{"a", 2.0}}, changes));
  };
  for (const char* line :
       {"[ moving_objects ]", "moving_objects.a = 1", "moving_objects = { a = 1 }"}) {
    const std::string text = std::string("# fitted\n") + line + "\n";
    EXPECT_THROW(refit(text), InputError) << line;
  }
  EXPECT_THROW(refit("[moving_objects]\n\"a\" = 1\n"), InputError);
  EXPECT_NO_THROW(refit("[moving_objects] # it's \"ours\"\n"));
}

TEST(FitPreset, FittedTwiceIsTheSame) {
  std::string changes;
  const std::string once = with_keys("[moving_objects]\n", {{"a", 1.0 / 3.0}}, changes);
  EXPECT_EQ(with_keys(once, {{"a", 1.0 / 3.0}}, changes), once);
}

}  // namespace
}  // namespace egomod::fit
