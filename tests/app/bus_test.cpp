// SPDX-License-Identifier: Apache-2.0
// A subscriber in another process than the daemon, over UDP multicast on loopback.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "run_program.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;

constexpr double kRate_hz = 30.0;
constexpr int kRenderedPairs = 10;
constexpr long kReceiveBufferBytes = 2097152;
const std::string kUrl = "udpm://239.255.76.67:7667?ttl=0";
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// Of the pairs of a run at 30 Hz; the machine may be busy with other things too.
constexpr double kMaxDroppedShare = 0.1;
#else
constexpr double kMaxDroppedShare = 1.0;
#endif

using Counts = std::map<std::string, int>;

// A network of our own, with a multicast route on loopback.
bool enter_private_network() {
  const int flags = geteuid() == 0 ? CLONE_NEWNET : CLONE_NEWUSER | CLONE_NEWNET;
  return unshare(flags) == 0 && std::system(
                                    "ip link set lo up && ip link set lo multicast on && "
                                    "ip route add 224.0.0.0/4 dev lo") == 0;
}

// `pairs` pairs that go to and fro over the few that are rendered.
void write_sequence(const fs::path& rendered, const fs::path& folder, int pairs) {
  fs::create_directories(folder);
  fs::copy_file(rendered / "calib.txt", folder / "calib.txt");
  std::ofstream times(folder / "times.txt");
  for (int i = 0; i < pairs; ++i) times << i / kRate_hz << '\n';
  for (const char* side : {"image_0", "image_1"}) {
    fs::create_directories(folder / side);
    const auto name = [](int index) { return std::to_string(1000000 + index).substr(1) + ".png"; };
    for (int i = 0; i < pairs; ++i) {
      const int phase = i % (2 * kRenderedPairs - 2);
      const int source = phase < kRenderedPairs ? phase : 2 * kRenderedPairs - 2 - phase;
      fs::create_symlink(rendered / side / name(source), folder / side / name(i));
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

// The number before a word of the daemon's summary; -1 if it is not there.
double figure(const std::string& summary, const std::string& word) {
  std::smatch found;
  const bool is_there = std::regex_search(summary, found, std::regex("([0-9.]+) " + word));
  return is_there ? std::stod(found[1]) : -1.0;
}

// What a paced run of the daemon records, and what a subscriber received of it.
struct Traffic {
  int pairs = 0;
  int dropped = -1;
  Counts recorded{};
  Counts received{};
};

struct Paced {
  int seconds = 8;
  std::string images = "none";
  std::string url = kUrl;
};

class Bus : public ::testing::Test {
 protected:
  Bus() : folder_(fs::path(::testing::TempDir()) / ("egomod_bus_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~Bus() override { fs::remove_all(folder_); }

  // Starts the daemon on `pairs` pairs; a subscriber counts while it runs.
  Traffic traffic_of(const Paced& run) {
    Traffic traffic{.pairs = static_cast<int>(kRate_hz) * run.seconds};
    write_sequence(rendered(), folder_ / "sequence", traffic.pairs);
    lcm::LCM bus(run.url);
    EXPECT_TRUE(bus.good());
    bus.subscribeFunction("EGOMOD_(POSE|VELOCITY|OBJECTS|IMAGES)", &count, &traffic.received)
        ->setQueueCapacity(0);
    const pid_t daemon = start({"--source=folder:" + (folder_ / "sequence").string(), "--realtime",
                                "--set=publish.images=" + run.images, "--lcm-url=" + run.url,
                                "--record=" + (folder_ / "record").string()});
    int status = 0;
    while (waitpid(daemon, &status, WNOHANG) == 0) bus.handleTimeout(100);
    while (bus.handleTimeout(300) > 0) {
    }
    EXPECT_EQ(WEXITSTATUS(status), 0) << read(folder_ / "output");
    traffic.dropped = static_cast<int>(figure(read(folder_ / "output"), "dropped"));
    traffic.recorded = count_record((folder_ / "record").string());
    return traffic;
  }

  // In a minute's run VGA images, if the machine processes them half as fast again as they come.
  fs::path rendered() {
    const fs::path sequences = EGOMOD_TEST_SEQUENCES;
    if (!takes_a_minute()) return sequences / "fast_320";
    write_sequence(sequences / "fast_640", folder_ / "trial", 90);
    const pid_t daemon =
        start({"--source=folder:" + (folder_ / "trial").string(), "--lcm-url=memq://"});
    waitpid(daemon, nullptr, 0);
    const double rate_hz = figure(read(folder_ / "output"), "a second");
    const bool keeps_up = rate_hz >= 1.5 * kRate_hz;
    std::printf("640x480: %.1f pairs a second%s\n", rate_hz, keeps_up ? "" : ", so 320x240");
    return sequences / (keeps_up ? "fast_640" : "fast_320");
  }

  static bool takes_a_minute() { return std::getenv("EGOMOD_LONG_TESTS") != nullptr; }

  // Every pair is there or counted as dropped, few are, and the subscriber has all that is
  // recorded.
  static void expect_complete(Traffic& traffic, std::initializer_list<std::string> channels) {
    EXPECT_EQ(traffic.recorded["EGOMOD_POSE"] + traffic.dropped, traffic.pairs);
    EXPECT_LE(traffic.dropped, kMaxDroppedShare * traffic.pairs);
    for (const std::string& channel : channels) {
      EXPECT_EQ(traffic.recorded[channel], traffic.recorded["EGOMOD_POSE"]) << channel;
      EXPECT_EQ(traffic.received[channel], traffic.recorded[channel]) << channel;
    }
  }

 private:
  pid_t start(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), EGOMODD);
    return start_program(arguments, folder_ / "output");
  }

  const fs::path folder_;
};

bool has_jpeg_buffer() {
  long allowed_bytes = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> allowed_bytes;
  return allowed_bytes >= kReceiveBufferBytes;
}

TEST_F(Bus, a_subscriber_receives_each_message_that_is_recorded_at_30_hz) {
  if (!enter_private_network()) {
    GTEST_SKIP() << "no private network with a multicast route on loopback may be had here";
  }
  const bool is_minute = takes_a_minute() && !has_jpeg_buffer();
  Traffic traffic = traffic_of({.seconds = is_minute ? 60 : 8});
  expect_complete(traffic, {"EGOMOD_POSE", "EGOMOD_VELOCITY", "EGOMOD_OBJECTS"});
}

TEST_F(Bus, a_subscriber_with_a_receive_buffer_of_2_mb_receives_each_jpeg_pair_too) {
  if (!has_jpeg_buffer()) {
    GTEST_SKIP() << "net.core.rmem_max is less than " << kReceiveBufferBytes;
  }
  if (!enter_private_network()) {
    GTEST_SKIP() << "no private network with a multicast route on loopback may be had here";
  }
  Traffic traffic =
      traffic_of({.seconds = takes_a_minute() ? 60 : 4,
                  .images = "jpeg",
                  .url = kUrl + "&recv_buf_size=" + std::to_string(kReceiveBufferBytes)});
  expect_complete(traffic, {"EGOMOD_POSE", "EGOMOD_VELOCITY", "EGOMOD_OBJECTS", "EGOMOD_IMAGES"});
}

}  // namespace
}  // namespace egomod
