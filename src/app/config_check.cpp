// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdlib>
#include <initializer_list>
#include <string>
#include <string_view>

#include "egomod/app/config.hpp"
#include "egomod/capture/frame_source.hpp"
#include "egomod/core/instruction_set.hpp"
#include "egomod/pipeline/pipeline.hpp"

namespace egomod {
namespace {

// Of several keys that do not go together the first that was set is to blame.
[[noreturn]] void refuse(const ConfigOrigins& origins, std::initializer_list<std::string_view> keys,
                         const std::string& why) {
  for (const std::string_view key : keys) {
    if (const auto origin = origins.find(key); origin != origins.end()) {
      throw ConfigError(fmt::format("{}: {}: {}", origin->second, key, why));
    }
  }
  throw ConfigError(fmt::format("{}: {}", *keys.begin(), why));
}

void check_cpus(const Config& config, const ConfigOrigins& origins) {
  try {
    (void)parse_cpus(config.pipeline.cpus);
  } catch (const std::invalid_argument& error) {
    refuse(origins, {"pipeline.cpus"}, error.what());
  }
}

void check_max_tracks(const Config& config, const ConfigOrigins& origins) {
  constexpr int kLeast = 16;
  const int tracks = config.features.max_tracks;
  if (tracks != 0 && tracks < kLeast) {
    refuse(origins, {"features.max_tracks"},
           fmt::format("want 0 or at least {} tracks, not {}", kLeast, tracks));
  }
}

void check_instruction_set() {
  const char* const set = std::getenv(kInstructionSetVariable);
  if (set != nullptr && !instruction_set_named(set)) {
    throw ConfigError(
        fmt::format("{}={}: want baseline, x86-64-v3 or x86-64-v4", kInstructionSetVariable, set));
  }
}

void check_lag(const Config& config, const ConfigOrigins& origins) {
  const MovingObjectsConfig& objects = config.moving_objects;
  if (objects.min_lag_s <= objects.lag_s && objects.lag_s <= objects.max_lag_s) {
    return;
  }
  refuse(origins, {"moving_objects.lag_s", "moving_objects.min_lag_s", "moving_objects.max_lag_s"},
         fmt::format("want min_lag_s <= lag_s <= max_lag_s, not {} <= {} <= {}", objects.min_lag_s,
                     objects.lag_s, objects.max_lag_s));
}

void check_channels(const Config& config, const ConfigOrigins& origins) {
  const auto& [left, right] = std::pair{config.capture.left_channel, config.capture.right_channel};
  const auto keys = {std::string_view("capture.left_channel"),
                     std::string_view("capture.right_channel")};
  if (left.empty() != right.empty()) {
    refuse(origins, keys, "want both left_channel and right_channel, or neither");
  }
  if (!left.empty() && left == right) {
    refuse(origins, keys, fmt::format("left_channel and right_channel are both \"{}\"", left));
  }
}

// It would take its own images for the cameras'.
void check_images(const Config& config, const ConfigOrigins& origins) {
  constexpr std::string_view kImages = "EGOMOD_IMAGES";
  const CaptureConfig& capture = config.capture;
  const bool reads_them = config.daemon.source == "lcm" &&
                          (capture.left_channel.empty() || capture.left_channel == kImages ||
                           capture.right_channel == kImages);
  if (config.publish.images == ImageEncoding::kNone || !reads_them) {
    return;
  }
  refuse(origins, {"publish.images", "daemon.source"},
         "the source lcm reads EGOMOD_IMAGES, on which the daemon must not publish images then; "
         "want \"none\", or channels of the cameras' own in capture.left_channel and "
         "capture.right_channel");
}

}  // namespace

void check(const Config& config, const ConfigOrigins& origins) {
  check_instruction_set();
  check_max_tracks(config, origins);
  check_cpus(config, origins);
  check_lag(config, origins);
  check_channels(config, origins);
  check_images(config, origins);
}

void check_source_and_rig(const Config& config, const ConfigOrigins& origins) {
  std::string_view key = "daemon.source";
  try {
    if (!config.daemon.source.empty()) {
      check_source(config.daemon.source);
    }
    key = "daemon.rig";
    if (!config.daemon.rig.empty()) {
      check_rig(config.daemon.rig);
    }
  } catch (const SourceError& error) {
    refuse(origins, {key}, error.what());
  }
}

}  // namespace egomod
