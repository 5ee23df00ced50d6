// SPDX-License-Identifier: Apache-2.0
// The real daemon on worlds that the real egomod-sim renders, in a private network.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <egomod/command_t.hpp>
#include <egomod/odometry_t.hpp>
#include <egomod/truth_pose_t.hpp>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <string>
#include <thread>
#include <vector>

#include "gl_context.hpp"
#include "record_truth.hpp"
#include "run_program.hpp"
#include "sequence.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

const std::string kUrl = "udpm://239.255.76.67:7667?ttl=0";
const std::string kNoBus = "--lcm-url=memq://";
constexpr int kPairs = 16;

constexpr const char* kRoom = R"(
seed = 5
[camera]
width_px = 320
height_px = 240
rate_hz = 16.0
left = { distortion = [0.02, -0.05, 0.0005, -0.0005, 0.0] }
[shell]
kind = "room"
width_m = 3.0
length_m = 5.0
height_m = 2.0
[[object]]
kind = "pioneer"
motion = { kind = "arc", position_m = [-0.8, 2.5], speed_mps = 0.1, turn_degps = 9.0 }
)";
constexpr const char* kOwnWay = R"(
[rig]
motion = { kind = "line", position_m = [0.0, 0.0], speed_mps = 0.5 }
)";
constexpr const char* kDriven = R"(
[rig]
[rig.driven]
position_m = [0.0, 0.0]
lag_s = 0.0
)";
constexpr const char* kScript = R"(
[[rig.driven.command]]
at_s = 0.25
speed_mps = 0.12
[[rig.driven.command]]
at_s = 0.75
)";

struct Message {
  std::string channel;
  std::string bytes;
};

// All but SIM_TRUTH_*, or only them.
std::vector<Message> messages_of(const fs::path& record, bool truth) {
  std::vector<Message> messages;
  lcm::LogFile log(record, "r");
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    if (event->channel.starts_with("SIM_TRUTH") != truth) continue;
    messages.push_back({event->channel, std::string(static_cast<const char*>(event->data),
                                                    static_cast<std::size_t>(event->datalen))});
  }
  return messages;
}

std::vector<truth_pose_t> true_poses(const fs::path& record) {
  std::vector<truth_pose_t> poses;
  for (const Message& message : messages_of(record, true)) {
    truth_pose_t pose{};
    if (message.channel != "SIM_TRUTH_POSE") continue;
    EXPECT_GT(pose.decode(message.bytes.data(), 0, static_cast<int>(message.bytes.size())), 0);
    poses.push_back(pose);
  }
  return poses;
}

void expect_same(const eval::Truth& files, const eval::Truth& record) {
  constexpr double kPrinted = 2e-5;  // the last digit of the files
  ASSERT_EQ(files.times_s.size(), record.times_s.size());
  for (std::size_t i = 0; i < files.times_s.size(); ++i) {
    EXPECT_NEAR(files.times_s[i], record.times_s[i], kPrinted);
    EXPECT_TRUE(files.poses[i].T_world_camera.isApprox(record.poses[i].T_world_camera, kPrinted));
    const eval::TruthObject& a = files.objects->at(static_cast<int>(i)).at(0);
    const eval::TruthObject& b = record.objects->at(static_cast<int>(i)).at(0);
    EXPECT_NEAR((a.surface_m - b.surface_m).norm(), 0.0, kPrinted);
    EXPECT_NEAR((a.velocity_mps - b.velocity_mps).norm(), 0.0, kPrinted);
    EXPECT_EQ(a.visible_px, b.visible_px);
    EXPECT_EQ(a.rectangle.u_max_px, b.rectangle.u_max_px);
    EXPECT_EQ(a.moving, b.moving);
  }
}

class DaemonOnWorld : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      const sim::GlContext context;
    } catch (const sim::GlError& error) {
      GTEST_SKIP() << error.what();
    }
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string world(const std::string& rig, double duration_s = 1.0) const {
    const fs::path file = folder_ / "world.toml";
    std::ofstream(file) << "duration_s = " << std::to_string(duration_s) << kRoom << rig;
    return file;
  }
  Outcome run(const std::string& source, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command{EGOMODD, "--source", source, kNoBus};
    command.insert(command.end(), more.begin(), more.end());
    return run_program(command, folder_ / "output");
  }
  void record(const std::string& source, const fs::path& file,
              const std::vector<std::string>& more = {}) const {
    std::vector<std::string> options{"--quiet", "--record", file};
    options.insert(options.end(), more.begin(), more.end());
    const Outcome outcome = run(source, options);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  }

  const fs::path folder_ =
      fs::path(::testing::TempDir()) / ("egomod_on_world_" + std::to_string(getpid()));
};

TEST_F(DaemonOnWorld, RecordsTheSameBytesEachTimeWithOneThreadAndWithFive) {
  const std::string source = "sim:" + world(kOwnWay);
  record(source, folder_ / "five");
  record(source, folder_ / "again");
  record(source, folder_ / "one", {"--single-thread"});
  const std::string five = read(folder_ / "five");
  EXPECT_GT(five.size(), 1000U * kPairs);
  EXPECT_EQ(five, read(folder_ / "again"));
  EXPECT_EQ(five, read(folder_ / "one"));
}

TEST_F(DaemonOnWorld, RecordsWhatTheRenderedFolderGivesAndTheTruthBehindEachPair) {
  const std::string file = world(kOwnWay);
  const fs::path folder = folder_ / "rendered";
  ASSERT_EQ(run_program({EGOMOD_SIM, file, "--out", folder}, folder_ / "output").exit_code, 0);
  record("sim:" + file, folder_ / "from_world");
  record("folder:" + folder.string(), folder_ / "from_folder");
  const auto from_world = messages_of(folder_ / "from_world", false);
  const auto from_folder = messages_of(folder_ / "from_folder", false);
  ASSERT_EQ(from_world.size(), from_folder.size());
  for (std::size_t i = 0; i < from_world.size(); ++i) {
    EXPECT_EQ(from_world[i].channel, from_folder[i].channel);
    EXPECT_EQ(from_world[i].bytes, from_folder[i].bytes) << from_world[i].channel << ' ' << i;
  }
  expect_same(eval::read_truth(folder), eval::read_truth_of_record(folder_ / "from_world"));
  const auto poses = true_poses(folder_ / "from_world");
  ASSERT_EQ(poses.size(), static_cast<std::size_t>(kPairs));
  EXPECT_EQ(poses[8].utime, 500'000);
  EXPECT_EQ(poses[8].sequence, 8);
  EXPECT_NEAR(poses[8].pos[0], 0.25, 1e-9);
  EXPECT_NEAR(poses[8].vel[0], 0.5, 1e-6);
}

TEST_F(DaemonOnWorld, RefusesAWorldThatIsNotThere) {
  const Outcome outcome = run("sim:atlantis");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, AllOf(HasSubstr("atlantis: no such world in"),
                                    HasSubstr("there are: approaching"), HasSubstr("crossing")));
  const Outcome broken = run("sim:" + world("[rig]\nmotion = 3\n"));
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_THAT(broken.output, HasSubstr("world.toml:17: rig.motion: a table is needed"));
}

// 0.12 m/s is reached after 0.4 s; the base brakes as fast.
TEST_F(DaemonOnWorld, DrivesTheRigByTheScriptOfItsWorld) {
  const std::string source = "sim:" + world(std::string(kDriven) + kScript, 1.25);
  record(source, folder_ / "a");
  record(source, folder_ / "b", {"--single-thread"});
  EXPECT_EQ(read(folder_ / "a"), read(folder_ / "b"));
  const auto poses = true_poses(folder_ / "a");
  ASSERT_EQ(poses.size(), 20U);
  EXPECT_NEAR(poses[4].pos[0], 0.0, 1e-9);
  EXPECT_NEAR(poses[8].pos[0], 0.5 * 0.3 * 0.25 * 0.25, 1e-9);
  EXPECT_NEAR(poses[12].pos[0], 0.12 * 0.5 - 0.5 * 0.12 * 0.4, 1e-9);
  EXPECT_NEAR(poses[19].pos[0], 0.12 * 0.5, 1e-9);
}

TEST_F(DaemonOnWorld, RecordsTheWheelsSoThatTheRecordReplaysWithThem) {
  record("sim:" + world(std::string(kDriven) + kScript, 1.25), folder_ / "world",
         {"--set", "publish.images=raw"});
  record("log:" + (folder_ / "world").string(), folder_ / "replay");
  const auto of_channel = [&](const char* record, const std::string& channel) {
    std::vector<std::string> bytes;
    for (const Message& message : messages_of(folder_ / record, false)) {
      if (message.channel == channel) bytes.push_back(message.bytes);
    }
    return bytes;
  };
  EXPECT_EQ(of_channel("world", "EGOMOD_POSE"), of_channel("replay", "EGOMOD_POSE"));
  const auto wheels = of_channel("world", "PIONEER_ODOMETRY");
  ASSERT_EQ(wheels.size(), 20U);
  odometry_t last{};
  ASSERT_GT(last.decode(wheels.back().data(), 0, static_cast<int>(wheels.back().size())), 0);
  EXPECT_NEAR(last.x, 0.12 * 0.5, 1e-6);
  EXPECT_EQ(last.utime, 1'187'500);
}

TEST_F(DaemonOnWorld, KeepsTheWallClockAndCountsWhatItLeavesOut) {
  // More pairs than anything can render.
  const std::string file = world(kOwnWay);
  std::string text = read(file);
  text.replace(text.find("rate_hz = 16.0"), 14, "rate_hz = 900.0");
  std::ofstream(file) << text;
  const auto begin = std::chrono::steady_clock::now();
  const Outcome outcome = run("sim:" + file, {"--realtime"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_GT(std::chrono::steady_clock::now() - begin, 0.99s);
  EXPECT_THAT(
      outcome.output,
      ContainsRegex("warning: 0 images never came from the source, [1-9][0-9]* came too late"));
  EXPECT_THAT(outcome.output, HasSubstr("0 failed"));
}

TEST_F(DaemonOnWorld, EndsTheSimulatorEvenWhenItIsKilledItself) {
  const fs::path output = folder_ / "output";
  const pid_t daemon =
      start_program({EGOMODD, "--source", "sim:" + world(kDriven, 0.0), kNoBus}, output);
  const std::string children =
      "/proc/" + std::to_string(daemon) + "/task/" + std::to_string(daemon) + "/children";
  pid_t simulator = 0;
  for (int i = 0; i < 1000 && !(std::ifstream(children) >> simulator); ++i) {
    std::this_thread::sleep_for(10ms);
  }
  ASSERT_GT(simulator, 0) << read(output);
  std::this_thread::sleep_for(200ms);
  kill(daemon, SIGKILL);
  EXPECT_EQ(wait_for_program(daemon, output).exit_code, -1);
  const fs::path process = "/proc/" + std::to_string(simulator) + "/exe";
  std::error_code gone;  // a zombie that nobody waits for has none either
  for (int i = 0; i < 1000 && !gone; ++i) {
    static_cast<void>(fs::read_symlink(process, gone));
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_TRUE(gone);
}

// A commander that wants the base to go straight ahead, and notes where it is.
struct Commander {
  static void on_odometry(const lcm::ReceiveBuffer* buffer, const std::string& /*channel*/,
                          Commander* self) {
    odometry_t odometry{};
    if (odometry.decode(buffer->data, 0, static_cast<int>(buffer->data_size)) < 0) return;
    self->last = odometry;
    const command_t command{.utime = odometry.utime,
                            .sequence = ++self->sequence,
                            .linear = 0.5,
                            .angular = 0.0,
                            .valid_for = 1.0};
    self->bus.publish("PIONEER_COMMAND", &command);
  }

  lcm::LCM bus{kUrl};
  std::int64_t sequence = 0;
  odometry_t last{};
};

bool enter_private_network() {
  const int flags = geteuid() == 0 ? CLONE_NEWNET : CLONE_NEWUSER | CLONE_NEWNET;
  return unshare(flags) == 0 && std::system(
                                    "ip link set lo up && ip link set lo multicast on && "
                                    "ip route add 224.0.0.0/4 dev lo") == 0;
}

TEST_F(DaemonOnWorld, DrivesTheRigByCommandsFromTheBusForAsLongAsItIsWanted) {
  if (!enter_private_network()) GTEST_SKIP() << "no private network: needs root or user namespaces";
  Commander commander;
  ASSERT_TRUE(commander.bus.good());
  commander.bus.subscribeFunction("PIONEER_ODOMETRY", &Commander::on_odometry, &commander);
  const fs::path output = folder_ / "output";
  const fs::path file = folder_ / "record";
  const pid_t daemon = start_program(
      {EGOMODD, "--source", "sim:" + world(kDriven, 0.0), "--lcm-url", kUrl, "--record", file},
      output);
  while (commander.last.x < 0.3 && commander.bus.handleTimeout(60'000) > 0) {
  }
  EXPECT_GE(commander.last.x, 0.3) << read(output);
  kill(daemon, SIGTERM);
  const Outcome outcome = wait_for_program(daemon, output);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  // The odometry of a pair is out before the pair: what is recorded ends about there.
  EXPECT_NEAR(true_poses(file).back().pos[0], commander.last.x, 0.2);
  EXPECT_NEAR(true_poses(file).back().pos[1], 0.0, 1e-6);
}

}  // namespace
}  // namespace egomod
