// SPDX-License-Identifier: Apache-2.0
#include "log_reader.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

namespace egomod::log {
namespace {

// Sync word, event number, time, two lengths.
constexpr std::int64_t kEventHeaderBytes = 28;
constexpr std::int64_t kFingerprintBytes = 8;

std::int64_t bytes_of(const lcm::LogEvent& event) {
  return kEventHeaderBytes + static_cast<std::int64_t>(event.channel.size()) + event.datalen;
}

}  // namespace

LogReader::LogReader(std::string path) : path_(std::move(path)), file_(path_, "r") {
  if (!file_.good()) {
    throw LogError(fmt::format("{}: cannot be opened: {}", path_, std::strerror(errno)));
  }
  std::error_code error;
  const auto size = std::filesystem::file_size(path_, error);
  if (error) throw LogError(fmt::format("{}: cannot be read: {}", path_, error.message()));
  size_bytes_ = static_cast<std::int64_t>(size);
}

const lcm::LogEvent* LogReader::next() {
  const lcm::LogEvent* const event = file_.readNextEvent();
  if (event == nullptr) {
    if (offset_bytes_ == 0 && size_bytes_ != 0) {
      damage_ = path_ + ": is not an LCM log, or cut off within its first event";
    } else if (offset_bytes_ != size_bytes_) {
      damage_ = fmt::format("{}: the log is cut off: {} of {} bytes hold whole events", path_,
                            offset_bytes_, size_bytes_);
    }
    return nullptr;
  }
  const std::int64_t expected = offset_bytes_ + bytes_of(*event);
  offset_bytes_ = std::ftell(file_.getFilePtr());
  if (offset_bytes_ != expected && damage_.empty()) {
    damage_ = fmt::format("{}: bytes that are no event before event {}", path_, event->eventnum);
  }
  return event;
}

void LogReader::require_whole() const {
  if (!damage_.empty()) throw LogError(damage_ + "; what is whole has been used");
}

void LogReader::fail_decode(const lcm::LogEvent& event, const std::string& type) const {
  throw LogError(fmt::format(
      "{}: event {} on {}: not an egomod {} of this version (fingerprint {:#018x}, {} bytes)",
      path_, event.eventnum, event.channel, type, static_cast<std::uint64_t>(fingerprint(event)),
      event.datalen));
}

std::int64_t fingerprint(const lcm::LogEvent& event) {
  if (event.datalen < kFingerprintBytes) return 0;
  const auto* const bytes = static_cast<const std::uint8_t*>(event.data);
  std::uint64_t value = 0;
  for (int i = 0; i < kFingerprintBytes; ++i) value = value << 8U | bytes[i];
  return static_cast<std::int64_t>(value);
}

}  // namespace egomod::log
