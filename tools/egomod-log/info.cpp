// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bot_core/images_t.hpp>
#include <cstdio>
#include <egomod/blackbox_t.hpp>
#include <egomod/calibration_t.hpp>
#include <egomod/command_t.hpp>
#include <egomod/follow_enable_t.hpp>
#include <egomod/follow_t.hpp>
#include <egomod/follow_target_t.hpp>
#include <egomod/health_t.hpp>
#include <egomod/object_list_t.hpp>
#include <egomod/odometry_t.hpp>
#include <egomod/pose_t.hpp>
#include <egomod/timing_t.hpp>
#include <egomod/track_list_t.hpp>
#include <egomod/truth_object_list_t.hpp>
#include <egomod/truth_pose_t.hpp>
#include <egomod/velocity_t.hpp>
#include <map>
#include <utility>

#include "commands.hpp"
#include "log_reader.hpp"

namespace egomod::log {
namespace {

using TypeNames = std::map<std::int64_t, std::string>;

template <typename... Messages>
TypeNames names_of() {
  return {{Messages::getHash(), std::string(Messages::getTypeName())}...};
}

TypeNames known_types() {
  return names_of<bot_core::image_t, bot_core::images_t, blackbox_t, calibration_t, command_t,
                  follow_enable_t, follow_t, follow_target_t, health_t, object_list_t, odometry_t,
                  pose_t, timing_t, track_list_t, truth_object_list_t, truth_pose_t, velocity_t>();
}

struct ChannelInfo {
  std::int64_t messages = 0;
  std::int64_t bytes = 0;
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;

  void add(const lcm::LogEvent& event) {
    if (messages++ == 0) first_us = last_us = event.timestamp;
    bytes += event.datalen;
    first_us = std::min(first_us, event.timestamp);
    last_us = std::max(last_us, event.timestamp);
  }

  [[nodiscard]] double rate_hz() const {
    return last_us > first_us
               ? static_cast<double>(messages - 1) * 1e6 / static_cast<double>(last_us - first_us)
               : 0.0;
  }
};

// One channel may carry several types.
using Contents = std::map<std::pair<std::string, std::int64_t>, ChannelInfo>;

Contents read_contents(LogReader& reader, ChannelInfo& total) {
  Contents contents;
  while (const lcm::LogEvent* event = reader.next()) {
    contents[{event->channel, fingerprint(*event)}].add(*event);
    total.add(*event);
  }
  return contents;
}

std::string type_name(const TypeNames& names, std::int64_t type) {
  const auto known = names.find(type);
  return known != names.end() ? known->second
                              : fmt::format("unknown {:#018x}", static_cast<std::uint64_t>(type));
}

// Channels of ours that carry what is no type of ours; other programs' may carry what they like.
std::string unknown_on_ours(const Contents& contents, const TypeNames& names) {
  std::string list;
  for (const auto& [key, channel] : contents) {
    const auto& [name, type] = key;
    if (!name.starts_with("EGOMOD_") || names.contains(type)) continue;
    list += fmt::format("{}{} ({} messages)", list.empty() ? "" : ", ", name, channel.messages);
  }
  return list;
}

void print_contents(const Contents& contents, const TypeNames& names) {
  fmt::print("{:<24}{:<32}{:>10}{:>10}{:>14}\n", "channel", "type", "messages", "Hz", "bytes");
  for (const auto& [key, channel] : contents) {
    fmt::print("{:<24}{:<32}{:>10}{:>10.2f}{:>14}\n", key.first, type_name(names, key.second),
               channel.messages, channel.rate_hz(), channel.bytes);
  }
}

}  // namespace

void print_info(const std::string& log) {
  LogReader reader(log);
  ChannelInfo total;
  const Contents contents = read_contents(reader, total);
  const TypeNames names = known_types();
  fmt::print("{}: {} messages, {} bytes, {:.6f} s from {:.6f} to {:.6f}\n", log, total.messages,
             total.bytes, static_cast<double>(total.last_us - total.first_us) * 1e-6,
             static_cast<double>(total.first_us) * 1e-6, static_cast<double>(total.last_us) * 1e-6);
  print_contents(contents, names);
  if (std::fflush(stdout) != 0) throw LogError("standard output: cannot be written");
  if (!reader.damage().empty()) throw LogError(reader.damage());
  const std::string unknown = unknown_on_ours(contents, names);
  if (unknown.empty()) return;
  throw LogError(log + ": messages of unknown type on " + unknown +
                 "; they were written by another version of egomod");
}

}  // namespace egomod::log
