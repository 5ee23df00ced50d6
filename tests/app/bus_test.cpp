// SPDX-License-Identifier: Apache-2.0
// A subscriber in another process than the daemon, over UDP multicast on loopback.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <string>

#include "kitti_writer.hpp"
#include "scenes.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;

constexpr double kRate_hz = 30.0;
constexpr int kRenderedPairs = 10;
const std::string kUrl = "udpm://239.255.76.67:7667?ttl=0";

using Counts = std::map<std::string, int>;

// A network of our own, with a multicast route on loopback.
bool enter_private_network() {
  const int flags = geteuid() == 0 ? CLONE_NEWNET : CLONE_NEWUSER | CLONE_NEWNET;
  return unshare(flags) == 0 && std::system(
                                    "ip link set lo up && ip link set lo multicast on && "
                                    "ip route add 224.0.0.0/4 dev lo") == 0;
}

// `pairs` pairs that go to and fro over the few that are rendered.
void write_sequence(const fs::path& folder, int pairs) {
  const test_support::SyntheticWorld world(test_support::following_robot(),
                                           test_support::kinect_pair(320));
  fs::create_directories(folder);
  test_support::write_kitti_sequence(world, {.rate_hz = kRate_hz, .pairs = kRenderedPairs}, folder);
  std::ofstream times(folder / "times.txt");
  for (int i = 0; i < pairs; ++i) {
    times << i / kRate_hz << '\n';
    const int phase = i % (2 * kRenderedPairs - 2);
    const int source = phase < kRenderedPairs ? phase : 2 * kRenderedPairs - 2 - phase;
    for (const char* side : {"image_0", "image_1"}) {
      const auto file = [&](int index) {
        std::string number = std::to_string(1000000 + index).substr(1);
        return folder / side / (number + ".png");
      };
      if (i >= kRenderedPairs) {
        fs::create_hard_link(file(source), file(i));
      }
    }
  }
}

Counts count_record(const std::string& path) {
  Counts counts;
  lcm::LogFile log(path, "r");
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    ++counts[event->channel];
  }
  return counts;
}

// A function, since GCC 12 miscompiles LCM's call of member functions under UBSan.
void count(const lcm::ReceiveBuffer*, const std::string& channel, Counts* counts) {
  ++(*counts)[channel];
}

// What a paced run of the daemon records, and what a subscriber received of it.
struct Traffic {
  Counts recorded;
  Counts received;
};

Traffic run_daemon(int seconds, const std::string& images, const std::string& url) {
  const fs::path folder =
      fs::path(::testing::TempDir()) / ("egomod_bus_" + std::to_string(getpid()));
  write_sequence(folder / "sequence", static_cast<int>(kRate_hz) * seconds);
  const std::string record = (folder / "record").string();
  lcm::LCM bus(url);
  EXPECT_TRUE(bus.good());
  Traffic traffic;
  bus.subscribeFunction("EGOMOD_(POSE|VELOCITY|OBJECTS|IMAGES)", &count, &traffic.received)
      ->setQueueCapacity(0);
  const std::string source = "--source=folder:" + (folder / "sequence").string();
  const std::string setting = "--set=publish.images=" + images;
  const pid_t daemon = fork();
  if (daemon == 0) {
    execl(EGOMODD, EGOMODD, source.c_str(), setting.c_str(), "--realtime", "--quiet", "--lcm-url",
          url.c_str(), "--record", record.c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  while (waitpid(daemon, &status, WNOHANG) == 0) {
    bus.handleTimeout(100);
  }
  while (bus.handleTimeout(300) > 0) {
  }
  EXPECT_EQ(WEXITSTATUS(status), 0);
  traffic.recorded = count_record(record);
  fs::remove_all(folder);
  return traffic;
}

TEST(Bus, a_subscriber_receives_each_message_that_is_recorded_at_30_hz) {
  if (!enter_private_network()) {
    GTEST_SKIP() << "no private network with a multicast route on loopback may be had here";
  }
  const int seconds = std::getenv("EGOMOD_LONG_TESTS") != nullptr ? 60 : 8;
  Traffic traffic = run_daemon(seconds, "none", kUrl);
  for (const char* channel : {"EGOMOD_POSE", "EGOMOD_VELOCITY", "EGOMOD_OBJECTS"}) {
    EXPECT_GT(traffic.recorded[channel], 0) << channel;
    EXPECT_EQ(traffic.received[channel], traffic.recorded[channel]) << channel;
  }
}

TEST(Bus, a_subscriber_with_a_receive_buffer_of_2_mb_receives_each_jpeg_pair) {
  constexpr long kReceiveBufferBytes = 2097152;
  long allowed_bytes = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> allowed_bytes;
  if (allowed_bytes < kReceiveBufferBytes) {
    GTEST_SKIP() << "net.core.rmem_max is " << allowed_bytes << ", want " << kReceiveBufferBytes;
  }
  if (!enter_private_network()) {
    GTEST_SKIP() << "no private network with a multicast route on loopback may be had here";
  }
  const int seconds = std::getenv("EGOMOD_LONG_TESTS") != nullptr ? 60 : 4;
  Traffic traffic =
      run_daemon(seconds, "jpeg", kUrl + "&recv_buf_size=" + std::to_string(kReceiveBufferBytes));
  EXPECT_GT(traffic.recorded["EGOMOD_IMAGES"], 0);
  EXPECT_EQ(traffic.received["EGOMOD_IMAGES"], traffic.recorded["EGOMOD_IMAGES"]);
}

}  // namespace
}  // namespace egomod
