// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <egomod/calibration_t.hpp>
#include <egomod/pose_t.hpp>
#include <egomod/track_list_t.hpp>
#include <egomod/velocity_t.hpp>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <random>
#include <string>

#include "egomod/moving_objects/evidence_gates.hpp"
#include "evidence_plot.hpp"
#include "filter_model.hpp"
#include "fit_fixture.hpp"
#include "labels.hpp"

namespace egomod::fit {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Optional;

ClassValues values_of(std::vector<double> still, std::vector<double> moving) {
  ClassValues values{std::move(still), std::move(moving)};
  values.sort();
  return values;
}

TEST(DecisionCut, CountsWhatLiesAboveIt) {
  const Score score = score_above(values_of({1, 2, 3, 4}, {3, 4, 5}), 3.0);
  EXPECT_EQ(score.true_positives, 2U);
  EXPECT_EQ(score.false_positives, 1U);
  EXPECT_EQ(score.false_negatives, 1U);
  EXPECT_DOUBLE_EQ(score.precision(), 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(score.recall(), 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(score.f1(), 2.0 / 3.0);
}

TEST(DecisionCut, KeepsWhatIsInForceAmongTheBest) {
  EXPECT_THAT(best_cut(values_of({1, 2}, {8, 9}), 0.5, 2.0), Optional(2.0));
  EXPECT_THAT(best_cut(values_of({1, 2}, {8, 9}), 0.5, 7.9), Optional(7.9));
}

TEST(DecisionCut, TakesTheMiddleOfTheGapWhereWhatIsInForceErrs) {
  EXPECT_THAT(best_cut(values_of({1, 2}, {8, 9}), 0.5, 0.0), Optional(5.0));
  EXPECT_THAT(best_cut(values_of({1, 2}, {8, 9}), 0.5, 8.0), Optional(5.0));
}

// N(0, 1) at rest and N(4, 1) moving: the log odds 4 x - 8 + ln(p / (1 - p)) are 0 at the cut.
TEST(DecisionCut, IsBayesOfTwoNormalLawsAtAnyPrior) {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  ClassValues values;
  for (int i = 0; i < 200'000; ++i) {
    values.add(false, normal(generator));
    values.add(true, 4.0 + normal(generator));
  }
  values.sort();
  for (const double prior : {0.1, 0.5, 0.9}) {
    const double bayes = 2.0 - 0.25 * std::log(prior / (1.0 - prior));
    EXPECT_THAT(best_cut(values, prior, 0.0), Optional(DoubleNear(bayes, 0.15))) << prior;
  }
}

TEST(DecisionCut, IsNoneWhereOneClassIsMissingOrOneAnswerForAllIsAsGood) {
  EXPECT_EQ(best_cut(values_of({}, {1, 2}), 0.5, 1.0), std::nullopt);
  EXPECT_EQ(best_cut(values_of({1, 2}, {}), 0.5, 1.0), std::nullopt);
  EXPECT_EQ(best_cut(values_of({3, 4}, {1, 2}), 0.5, 1.0), std::nullopt);
  EXPECT_EQ(best_cut(values_of({1, 1}, {1, 1}), 0.5, 1.0), std::nullopt);
}

// Two pairs with an object that moves at 4 m, the rig driving at 0.3 m/s.
class FitFilter : public FitFolder {
 protected:
  FitFilter() {
    truth(
        "0,1,3.9,4.1,100,100,200,200,1\n"
        "1,1,3.9,4.1,100,100,200,200,1\n");
  }
  static track_t track(bool on_mover, std::int8_t state, std::int64_t object, float evidence,
                       float chi2) {
    track_t t{};
    t.u = on_mover ? 150.0F : 400.0F;
    t.v = 150.0F;
    t.disparity = 50.0F;
    t.state = state;
    t.object_id = object;
    t.evidence = evidence;
    t.chi2 = chi2;
    t.vel[0] = 1.5F;
    return t;
  }
  // The same tracks in both pairs.
  std::string record(const std::vector<track_t>& tracks) const {
    calibration_t calibration{};
    calibration.fx = 500.0;
    calibration.baseline = 0.4;
    velocity_t velocity{};
    velocity.status = pose_t::STATUS_VALID;
    velocity.vel[0] = 0.3;
    track_list_t list{};
    list.tracks = tracks;
    list.n_tracks = static_cast<std::int32_t>(tracks.size());
    lcm::LogFile log(folder / "log", "w");
    append(log, "EGOMOD_CALIBRATION", calibration);
    append(log, "EGOMOD_VELOCITY", velocity);
    for (list.sequence = 0; list.sequence < 2; ++list.sequence) append(log, "EGOMOD_TRACKS", list);
    return folder / "log";
  }
};

TEST_F(FitFilter, LabelsPointsAndTheObjectsThatTheyMakeUp) {
  const std::string log = record({
      track(true, track_t::STATE_MOVING, 1, 10.0F, 50.0F),
      track(true, track_t::STATE_MOVING, 1, 20.0F, 60.0F),
      track(true, track_t::STATE_UNKNOWN, 0, 1.0F, 5.0F),  // not found
      track(false, track_t::STATE_STATIC, 0, -6.0F, 1.0F),
      track(false, track_t::STATE_MOVING, 2, 4.0F, 20.0F),  // false
      track(false, track_t::STATE_UNKNOWN, 0, 0.0F, 0.0F),  // of which the method says nothing
  });
  FilterSamples samples;
  EXPECT_EQ(add_record(log, folder, 0.5, samples), "");
  samples.sort();
  EXPECT_THAT(samples.evidence.moving, ElementsAre(1, 1, 10, 10, 20, 20));
  EXPECT_THAT(samples.evidence.still, ElementsAre(-6, -6, 4, 4));
  EXPECT_THAT(samples.chi2.still, ElementsAre(1, 1, 20, 20));
  EXPECT_EQ(samples.decided.true_positives, 4U);
  EXPECT_EQ(samples.decided.false_positives, 2U);
  EXPECT_EQ(samples.decided.false_negatives, 2U);
  // 30 of two points, correlated by a half; 0.9 of it is kept for the next pair.
  EXPECT_THAT(samples.pair_evidence.moving, ElementsAre(20.0));
  EXPECT_THAT(samples.summed_evidence.moving, ElementsAre(38.0));
  EXPECT_THAT(samples.pair_evidence.still, ElementsAre(4.0));
  EXPECT_THAT(samples.summed_evidence.still, ElementsAre(DoubleNear(7.6, 1e-12)));
  EXPECT_EQ(samples.velocities, 4U);
  EXPECT_NEAR(samples.velocity_variance_m2ps2, 1.5 * 1.5 / 3.0 - 0.09, 1e-9);
}

TEST_F(FitFilter, RecordsAddUp) {
  const std::string log = record({track(true, track_t::STATE_MOVING, 1, 10.0F, 50.0F)});
  FilterSamples samples;
  (void)add_record(log, folder, 0.5, samples);
  (void)add_record(log, folder, 0.5, samples);
  EXPECT_EQ(samples.evidence.moving.size(), 4U);
  EXPECT_EQ(samples.pair_evidence.moving.size(), 2U);  // ids are those of one record
}

TEST_F(FitFilter, TracksWithoutEvidenceAreRefusedWithTheRemedy) {
  const std::string log = record({track(true, track_t::STATE_MOVING, 1, 0.0F, 0.0F)});
  FilterSamples samples;
  try {
    (void)add_record(log, folder, 0.5, samples);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no track carries evidence"));
    EXPECT_THAT(error.what(), HasSubstr("moving_objects.method = \"filter\""));
  }
}

TEST_F(FitFilter, TruthWithoutObjectsIsRefused) {
  const std::string log = record({track(true, track_t::STATE_MOVING, 1, 10.0F, 50.0F)});
  std::filesystem::remove(folder / "objects.csv");
  file("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n");
  FilterSamples samples;
  EXPECT_THROW((void)add_record(log, folder, 0.5, samples), InputError);
}

TEST(FilterModel, FitsWhatTheSamplesTellAndNothingElse) {
  FilterSamples samples;
  samples.evidence = values_of({-6, -5, 5}, {7, 20, 25});
  samples.chi2 = values_of({1, 2, 3}, {30, 40, 50});
  samples.pair_evidence = values_of({13, 14}, {30, 40});
  samples.summed_evidence = values_of({}, {200, 300});  // no false object
  samples.velocities = 1000;
  samples.velocity_variance_m2ps2 = 0.25;
  const MovingObjectsConfig config;
  const FilterModel model = fit_model(samples, config, std::nullopt);
  EXPECT_EQ(model.evidence.present, kMovingEvidence);
  EXPECT_THAT(model.evidence.best, Optional(6.0));
  EXPECT_THAT(model.chi2.best, Optional(kMovingChi2));
  EXPECT_THAT(model.min_evidence.best, Optional(22.0));
  EXPECT_EQ(model.confirm_evidence.best, std::nullopt);
  EXPECT_THAT(model.velocity_prior_mps, Optional(0.5));
  samples.velocities = 10;
  EXPECT_EQ(fit_model(samples, config, std::nullopt).velocity_prior_mps, std::nullopt);
}

TEST_F(FitFilter, FigureIsDrawnAlsoWithoutObjects) {
  FilterSamples samples;
  samples.evidence = values_of({-6, -5, 5}, {7, 20, 25});
  samples.chi2 = values_of({0.001, 2, 3}, {30, 40, 50});
  const FilterModel model = fit_model(samples, MovingObjectsConfig{}, std::nullopt);
  EXPECT_GT(std::filesystem::file_size(draw_evidence(folder, "svg", samples, model)), 1000U);
}

}  // namespace
}  // namespace egomod::fit
