// SPDX-License-Identifier: Apache-2.0
#include "log_reader.hpp"

#include <fmt/format.h>

#include "capture/log_file.hpp"
#include "egomod/capture/frame_source.hpp"

namespace egomod::log {
namespace {

constexpr int kFingerprintBytes = 8;
constexpr int kListCountAt = 24;
constexpr int kListCountBytes = 4;

std::uint64_t big_endian(const lcm::LogEvent& event, int at, int count) {
  const auto* const bytes = static_cast<const std::uint8_t*>(event.data);
  std::uint64_t value = 0;
  for (int i = at; i < at + count; ++i) value = value << 8U | bytes[i];
  return value;
}

std::unique_ptr<LogFile> open(const std::string& path) {
  try {
    return std::make_unique<LogFile>(path);
  } catch (const SourceError& error) {
    throw LogError(error.what());
  }
}

}  // namespace

LogReader::LogReader(const std::string& path) : file_(open(path)) {}

LogReader::~LogReader() = default;

const lcm::LogEvent* LogReader::next() {
  const auto found = file_->next_event();
  if (!found) return nullptr;
  data_.resize(found->data_bytes);
  if (!file_->read(found->data_offset, data_)) {
    throw LogError(fmt::format("{}: event {} at byte {} cannot be read", file_->path(),
                               found->number, found->data_offset));
  }
  event_.eventnum = found->number;
  event_.timestamp = found->utime_us;
  event_.channel = found->channel;
  event_.datalen = static_cast<std::int32_t>(data_.size());
  event_.data = data_.data();
  return &event_;
}

const std::string& LogReader::damage() const { return file_->damage(); }

void LogReader::require_whole() const {
  if (!damage().empty()) throw LogError(damage() + "; what is whole has been used");
}

void LogReader::fail_decode(const lcm::LogEvent& event, const std::string& type) const {
  throw LogError(fmt::format(
      "{}: event {} on {}: not an egomod {} of this version (fingerprint {:#018x}, {} bytes)",
      file_->path(), event.eventnum, event.channel, type,
      static_cast<std::uint64_t>(fingerprint(event)), event.datalen));
}

bool LogReader::list_fits(const lcm::LogEvent& event) {
  if (event.datalen < kListCountAt + kListCountBytes) return false;
  const auto count = static_cast<std::int32_t>(big_endian(event, kListCountAt, kListCountBytes));
  return count >= 0 && count <= event.datalen;
}

std::int64_t fingerprint(const lcm::LogEvent& event) {
  if (event.datalen < kFingerprintBytes) return 0;
  return static_cast<std::int64_t>(big_endian(event, 0, kFingerprintBytes));
}

}  // namespace egomod::log
