// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <egomod/calibration_t.hpp>
#include <egomod/track_list_t.hpp>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <string>
#include <vector>

#include "fit_fixture.hpp"
#include "labels.hpp"
#include "plot.hpp"
#include "record_labels.hpp"

namespace egomod::fit {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class FitLabels : public FitFolder {
 protected:
  std::string error_of(const std::string& path) const {
    try {
      (void)read_labels(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
};

track_t track(float u, float v, float disparity, float speed_mps) {
  track_t t{};
  t.u = u;
  t.v = v;
  t.disparity = disparity;
  t.state = track_t::STATE_STATIC;
  t.vel[0] = speed_mps;
  return t;
}

TEST_F(FitLabels, ColumnsAreFoundByName) {
  const Labels labels =
      read_labels(file("l.csv", "# made up\nid,moving,speed_mps\n7, 1 ,0.5\n\n8,0,0.1\r\n"));
  EXPECT_THAT(labels.moving_mps, ElementsAre(0.5));
  EXPECT_THAT(labels.static_mps, ElementsAre(0.1));
}

TEST_F(FitLabels, WrittenLabelsReadBack) {
  write_labels(folder / "l.csv", {{0.1, 0.2}, {0.7}});
  const Labels labels = read_labels(folder / "l.csv");
  EXPECT_THAT(labels.static_mps, ElementsAre(0.1, 0.2));
  EXPECT_THAT(labels.moving_mps, ElementsAre(0.7));
}

TEST_F(FitLabels, ErrorsNameFileAndLine) {
  EXPECT_THAT(error_of(folder / "none.csv"), HasSubstr("none.csv: cannot be opened"));
  EXPECT_THAT(error_of(file("a.csv", "")), HasSubstr("a.csv: is empty"));
  EXPECT_THAT(error_of(file("b.csv", "speed,moving\n")), HasSubstr("b.csv:1: the header lacks"));
  EXPECT_THAT(error_of(file("c.csv", "speed_mps,moving\n0.1,0\nx,1\n")), HasSubstr("c.csv:3: "));
  EXPECT_THAT(error_of(file("d.csv", "speed_mps,moving\nnan,0\n")), HasSubstr("d.csv:2: "));
  EXPECT_THAT(error_of(file("e.csv", "speed_mps,moving\n-1,0\n")), HasSubstr("negative"));
  EXPECT_THAT(error_of(file("f.csv", "speed_mps,moving\n1,2\n")), HasSubstr("neither 0 nor 1"));
  EXPECT_THAT(error_of(file("g.csv", "speed_mps,moving\n1\n")), HasSubstr("g.csv:2: has 1 cells"));
}

TEST_F(FitLabels, RecordIsLabelledByTheTruthsRectanglesAndDepths) {
  truth(
      "4,1,3.9,4.1,100,100,200,200,1\n"
      "4,2,8.0,8.0,300,300,310,310,0\n");
  calibration_t calibration{};
  calibration.fx = 500.0;
  calibration.baseline = 0.4;
  track_list_t list{};
  list.sequence = 4;
  list.tracks = {track(150, 150, 50.0F, 0.5F),   // on the object, 4 m
                 track(150, 150, 20.0F, 0.25F),  // beside it, 10 m: left out
                 track(50, 50, 20.0F, 0.125F),   // background
                 track(305, 305, 25.0F, 0.75F),  // on an object at rest
                 track(150, 150, 0.0F, 0.9F)};   // without depth: left out
  list.tracks.push_back(track(50, 50, 20.0F, 3.0F));
  list.tracks.back().state = track_t::STATE_UNKNOWN;
  list.n_tracks = static_cast<std::int32_t>(list.tracks.size());
  {
    lcm::LogFile log(folder / "log", "w");
    append(log, "EGOMOD_CALIBRATION", calibration);
    append(log, "EGOMOD_TRACKS", list);
  }
  const auto [labels, damage] = label_record(folder / "log", folder);
  EXPECT_THAT(labels.moving_mps, ElementsAre(DoubleNear(0.5, 1e-6)));
  EXPECT_THAT(labels.static_mps, ElementsAre(0.125, 0.75));
  EXPECT_EQ(damage, "");
}

TEST_F(FitLabels, RansacMustAgreeOrDecidesAloneWhereThatIsAskedFor) {
  truth("4,1,3.9,4.1,100,100,200,200,1\n");
  calibration_t calibration{};
  calibration.fx = 500.0;
  calibration.baseline = 0.4;
  track_list_t list{};
  list.sequence = 4;
  const auto add = [&](float u, float speed_mps, std::int8_t role) {
    list.tracks.push_back(track(u, 150, 50.0F, speed_mps));
    list.tracks.back().role = role;
  };
  add(150, 0.5F, track_t::ROLE_OUTLIER);  // moves, and RANSAC says so
  add(150, 0.25F, track_t::ROLE_INLIER);  // moves, too slowly for RANSAC
  add(50, 0.125F, track_t::ROLE_INLIER);  // rests
  add(50, 2.0F, track_t::ROLE_OUTLIER);   // a mismatch
  add(50, 0.0625F, track_t::ROLE_UNUSED);
  list.n_tracks = static_cast<std::int32_t>(list.tracks.size());
  {
    lcm::LogFile log(folder / "log", "w");
    append(log, "EGOMOD_CALIBRATION", calibration);
    append(log, "EGOMOD_TRACKS", list);
  }
  const Labels agreed = label_record(folder / "log", folder, PointChoice::kRansac).labels;
  EXPECT_THAT(agreed.moving_mps, ElementsAre(0.5));
  EXPECT_THAT(agreed.static_mps, ElementsAre(0.125));
  const Labels roles = label_record(folder / "log", "no truth", PointChoice::kRoles).labels;
  EXPECT_THAT(roles.moving_mps, ElementsAre(0.5, 2.0));
  EXPECT_THAT(roles.static_mps, ElementsAre(0.25, 0.125));
  EXPECT_EQ(label_record(folder / "log", folder).labels.static_mps.size(), 3U);
}

TEST_F(FitLabels, TheWholePartOfATruncatedRecordIsUsedAndTheDamageTold) {
  truth("");
  track_list_t list{};
  list.tracks = {track(50, 50, 20.0F, 0.125F)};
  list.n_tracks = 1;
  {
    lcm::LogFile log(folder / "log", "w");
    append(log, "EGOMOD_CALIBRATION", calibration_t{});
    append(log, "EGOMOD_TRACKS", list);
    append(log, "EGOMOD_TRACKS", list);
  }
  std::filesystem::resize_file(folder / "log", std::filesystem::file_size(folder / "log") - 3);
  const auto [labels, damage] = label_record(folder / "log", folder);
  EXPECT_EQ(labels.static_mps.size(), 1U);
  EXPECT_THAT(damage, HasSubstr("the log is truncated at byte "));
}

TEST_F(FitLabels, ARecordOfWhichNoTracksAreWholeTellsTheDamage) {
  truth("");
  {
    lcm::LogFile log(folder / "log", "w");
    append(log, "EGOMOD_CALIBRATION", calibration_t{});
  }
  std::filesystem::resize_file(folder / "log", std::filesystem::file_size(folder / "log") - 3);
  try {
    (void)label_record(folder / "log", folder);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the log is truncated at byte 0,"));
  }
}

TEST_F(FitLabels, FigureIsDrawnIntoAFolderWhateverItsName) {
  std::filesystem::create_directories(folder / "it's \"here\"");
  const Labels labels{.static_mps = {0.1, 0.2, 0.3}, .moving_mps = {0.5, 1.0, 1.5}};
  const RayleighFit fit = fit_classifier(labels.static_mps, labels.moving_mps, 0.5);
  const std::string picture = draw_figure(folder / "it's \"here\"", "svg", labels, fit);
  EXPECT_GT(std::filesystem::file_size(picture), 1000U);
}

TEST_F(FitLabels, RecordWithoutTracksSaysSo) {
  truth("");
  {
    lcm::LogFile log(folder / "log", "w");
    append(log, "EGOMOD_CALIBRATION", calibration_t{});
  }
  EXPECT_THROW((void)label_record(folder / "log", folder), InputError);
  EXPECT_THROW((void)label_record(folder / "none", folder), std::runtime_error);
}

}  // namespace
}  // namespace egomod::fit
