// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <egomod/object_list_t.hpp>
#include <egomod/pose_t.hpp>
#include <limits>

#include "commands.hpp"
#include "egomod/publish/publisher.hpp"
#include "egomod/publish/record_writer.hpp"
#include "example_frame.hpp"
#include "log_reader.hpp"

namespace egomod::log {
namespace {

using testing::HasSubstr;

constexpr double kPoseDigits = 1e-8;

void record(const std::string& path, const std::vector<Frame>& frames, bool timing = false,
            ImageEncoding images = ImageEncoding::kNone) {
  Publisher publisher({.images = images, .tracks = true},
                      {.lcm_url = "no-such-provider://", .record = path, .record_timing = timing});
  for (const Frame& frame : frames) publisher.publish(frame);
  publisher.close();
}

template <typename... Frames>
std::vector<Frame> in_order(Frames... frames) {
  std::vector<Frame> result;
  (result.push_back(std::move(frames)), ...);
  return result;
}

std::vector<Eigen::Isometry3d> poses_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<Eigen::Isometry3d> poses;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  while (file) {
    for (int i = 0; i < 12; ++i) file >> T.matrix()(i / 4, i % 4);
    if (file) poses.push_back(T);
  }
  return poses;
}

std::string error_of(const auto& command) {
  try {
    command();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

TEST(Export, WritesThePoseOfTheLeftCameraInTheFirstOne) {
  const test::TemporaryFolder folder;
  std::vector<Frame> frames;
  for (std::uint64_t i = 0; i < 4; ++i) frames.push_back(test::some_frame(i));
  record(folder.file("log"), frames);
  export_log(folder.file("log"), folder.file("out"));
  const auto poses = poses_of(folder.file("out/poses.txt"));
  ASSERT_EQ(poses.size(), 4U);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_TRUE(poses[i].isApprox(frames[i].motion.T_first_current, kPoseDigits)) << i;
  }
  EXPECT_EQ(test::contents_of(folder.file("out/times.txt")),
            "0.000000\n0.100000\n0.200000\n0.300000\n");
  EXPECT_FALSE(std::filesystem::exists(folder.file("out/timing.csv")));
}

TEST(Export, RepeatsThePoseWhereAPairWasSkippedFailedOrIsMissing) {
  const test::TemporaryFolder folder;
  std::vector<Frame> frames =
      in_order(test::some_frame(0), test::some_frame(1), test::some_frame(2), test::some_frame(3),
               test::some_frame(5));
  frames[2].motion.status = EstimateStatus::kSkipped;
  frames[3].motion.status = EstimateStatus::kFailed;
  record(folder.file("log"), frames);
  export_log(folder.file("log"), folder.file("out"));
  const auto poses = poses_of(folder.file("out/poses.txt"));
  ASSERT_EQ(poses.size(), 6U);
  for (const std::size_t i : {1U, 2U, 3U, 4U}) {
    EXPECT_TRUE(poses[i].isApprox(frames[1].motion.T_first_current, kPoseDigits)) << i;
  }
  EXPECT_TRUE(poses[5].isApprox(frames[4].motion.T_first_current, kPoseDigits));
  EXPECT_THAT(test::contents_of(folder.file("out/times.txt")), HasSubstr("\n0.400000\n0.500000\n"));
}

TEST(Export, GivesThePairsBeforeALateRecordTimesThatAscend) {
  const test::TemporaryFolder folder;
  record(folder.file("log"), in_order(test::some_frame(3), test::some_frame(5)));
  export_log(folder.file("log"), folder.file("out"));
  EXPECT_EQ(test::contents_of(folder.file("out/times.txt")),
            "0.000000\n0.100000\n0.200000\n0.300000\n0.400000\n0.500000\n");
}

TEST(Export, LeavesAnEarlierResultWhereItFails) {
  const test::TemporaryFolder folder;
  record(folder.file("log"), in_order(test::some_frame(0), test::some_frame(1)));
  export_log(folder.file("log"), folder.file("out"));
  const std::string before = test::contents_of(folder.file("out/poses.txt"));
  record(folder.file("log"), in_order(test::some_frame(7), test::some_frame(2)));
  EXPECT_THAT(error_of([&] { export_log(folder.file("log"), folder.file("out")); }),
              HasSubstr("export one run at a time"));
  EXPECT_EQ(test::contents_of(folder.file("out/poses.txt")), before);
  EXPECT_FALSE(std::filesystem::exists(folder.file("out/poses.txt.part")));
}

TEST(Export, WritesMovingObjectsInTheLeftCameraFrame) {
  const test::TemporaryFolder folder;
  Frame frame = test::some_frame(1);
  frame.objects.objects.push_back(test::some_object(8));
  frame.objects.objects[1].state = ObjectState::kTentative;
  frame.objects.objects.push_back(test::some_object(9));
  frame.objects.objects[2].points = 0;
  record(folder.file("log"), in_order(test::some_frame(0), std::move(frame)));
  export_log(folder.file("log"), folder.file("out"));
  const std::string row =
      "10.500,20.000,99.000,80.250,1.000000,-0.500000,6.000000,0.400000,0.000000,-0.300000,12\n";
  EXPECT_EQ(test::contents_of(folder.file("out/objects.csv")),
            "frame,time,track_id,u_min,v_min,u_max,v_max,X,Y,Z,VX,VY,VZ,n_points\n"
            "0,0.000000,7," +
                row + "1,0.100000,7," + row);
}

TEST(Export, WritesTheHeaderWhenNothingMovesAndTimingWhenThereIs) {
  const test::TemporaryFolder folder;
  Frame frame = test::some_frame(0);
  frame.objects.objects.clear();
  frame.times[1] = {.start = Nanoseconds(1'000'000), .end = Nanoseconds(3'500'000)};
  record(folder.file("log"), in_order(std::move(frame)), true);
  export_log(folder.file("log"), folder.file("out"));
  EXPECT_EQ(test::contents_of(folder.file("out/objects.csv")),
            "frame,time,track_id,u_min,v_min,u_max,v_max,X,Y,Z,VX,VY,VZ,n_points\n");
  EXPECT_THAT(test::contents_of(folder.file("out/timing.csv")),
              HasSubstr("frame,time,stage,ms\n0,0.000000,capture,0.000000\n"
                        "0,0.000000,features,2.500000\n"));
}

TEST(Export, UsesWhatIsWholeOfATruncatedLogAndThenFails) {
  const test::TemporaryFolder folder;
  record(folder.file("log"), in_order(test::some_frame(0), test::some_frame(1)));
  std::filesystem::resize_file(folder.file("log"),
                               std::filesystem::file_size(folder.file("log")) - 3);
  EXPECT_THAT(error_of([&] { export_log(folder.file("log"), folder.file("out")); }),
              HasSubstr("truncated"));
  EXPECT_EQ(poses_of(folder.file("out/poses.txt")).size(), 2U);
  EXPECT_THAT(error_of([&] { print_info(folder.file("log")); }), HasSubstr("truncated"));
}

struct DamagedLengths {
  std::int32_t channel;
  std::int32_t data;
};

// Such an event, then bytes for it to be read from.
void append_event(const std::string& path, DamagedLengths lengths) {
  std::ofstream file(path, std::ios::binary | std::ios::app);
  const auto put = [&](std::int64_t value, int bytes) {
    for (int i = bytes - 1; i >= 0; --i) file.put(static_cast<char>(value >> (8 * i) & 0xFF));
  };
  put(0xEDA1DA01, 4);
  put(2, 8);
  put(300'000, 8);
  put(lengths.channel, 4);
  put(lengths.data, 4);
  file << "EGOMOD_POSE" << std::string(5000, 'x');
}

TEST(Export, UsesWhatIsWholeBeforeLengthsThatAreDamagedAndNamesThePlace) {
  constexpr std::int32_t kLowest = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kHighest = std::numeric_limits<std::int32_t>::max();
  const test::TemporaryFolder folder;
  for (const DamagedLengths lengths : {DamagedLengths{-1, 100},
                                       {kLowest, 100},
                                       {kHighest, 100},
                                       {4000, 100},
                                       {11, -1},
                                       {11, kLowest},
                                       {11, kHighest},
                                       {-1, -1}}) {
    SCOPED_TRACE(std::to_string(lengths.channel) + " and " + std::to_string(lengths.data));
    record(folder.file("log"), in_order(test::some_frame(0), test::some_frame(1)));
    const auto whole_bytes = std::filesystem::file_size(folder.file("log"));
    append_event(folder.file("log"), lengths);
    const auto names_the_place =
        testing::AllOf(HasSubstr(folder.file("log") + ": the log is "),
                       HasSubstr(" at byte " + std::to_string(whole_bytes) + ","));
    EXPECT_THAT(error_of([&] { export_log(folder.file("log"), folder.file("out")); }),
                names_the_place);
    EXPECT_EQ(poses_of(folder.file("out/poses.txt")).size(), 2U);
    EXPECT_THAT(error_of([&] { print_info(folder.file("log")); }), names_the_place);
  }
}

TEST(Export, NamesTheEventWhoseMessageHoldsADamagedCount) {
  const test::TemporaryFolder folder;
  for (const std::uint8_t highest_byte : {std::uint8_t{0x7F}, std::uint8_t{0xFF}}) {
    object_list_t list{};
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(list.getEncodedSize()));
    list.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    std::fill(bytes.end() - 4, bytes.end(), 0xFF);  // the count comes last
    *(bytes.end() - 4) = highest_byte;
    {
      RecordWriter writer(folder.file("log"));
      const std::string channel = "EGOMOD_OBJECTS";
      writer.write({channel, 0, bytes});
      writer.flush();
    }
    EXPECT_THAT(error_of([&] { export_log(folder.file("log"), folder.file("out")); }),
                HasSubstr("event 0 on EGOMOD_OBJECTS: not an egomod object_list_t"));
  }
}

TEST(Info, NamesAChannelWithAnUnknownType) {
  const test::TemporaryFolder folder;
  {
    RecordWriter writer(folder.file("log"));
    const std::string channel = "EGOMOD_POSE";
    const std::vector<std::uint8_t> bytes(16, 1);
    writer.write({channel, 0, bytes});
    writer.flush();
  }
  EXPECT_THAT(error_of([&] { print_info(folder.file("log")); }), HasSubstr("EGOMOD_POSE"));
  EXPECT_THAT(error_of([&] { export_log(folder.file("log"), folder.file("out")); }),
              HasSubstr("EGOMOD_POSE"));
}

TEST(Draw, MakesAPictureOfEachLeftImage) {
  const test::TemporaryFolder folder;
  record(folder.file("log"), in_order(test::some_frame(0), test::some_frame(1)), false,
         ImageEncoding::kJpeg);
  draw_log(folder.file("log"), folder.file("out"), "");
  EXPECT_GT(std::filesystem::file_size(folder.file("out/000001.png")), 0U);
}

TEST(Draw, NamesTheDamageThatLeavesNoImage) {
  const test::TemporaryFolder folder;
  record(folder.file("log"), in_order(test::some_frame(0)));
  append_event(folder.file("log"), {11, -1});
  EXPECT_THAT(error_of([&] { draw_log(folder.file("log"), folder.file("out"), ""); }),
              HasSubstr(folder.file("log") + ": the log is damaged at byte "));
}

TEST(Draw, NumbersPicturesAsThePairsAre) {
  const test::TemporaryFolder folder;
  Frame skipped = test::some_frame(1);
  skipped.pair.status = PairStatus::kSkipped;
  skipped.pair.left.resize(0, 0);
  skipped.pair.right.resize(0, 0);
  record(folder.file("log"), in_order(test::some_frame(0), std::move(skipped), test::some_frame(6)),
         false, ImageEncoding::kRaw);
  draw_log(folder.file("log"), folder.file("out"), "");
  for (const auto& [name, is_there] :
       {std::pair{"out/000000.png", true}, {"out/000001.png", false}, {"out/000006.png", true}}) {
    EXPECT_EQ(std::filesystem::exists(folder.file(name)), is_there) << name;
  }
}

}  // namespace
}  // namespace egomod::log
