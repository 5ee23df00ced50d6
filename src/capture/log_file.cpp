// SPDX-License-Identifier: Apache-2.0
#include "capture/log_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

// Big-endian: sync word, event number (8), time in microseconds (8), channel length (4), data
// length (4); then channel and data.
constexpr std::uint32_t kSyncWord = 0xEDA1DA01;
constexpr std::size_t kHeaderBytes = 28;
constexpr std::uint32_t kMaxChannelBytes = 1000;
constexpr std::uint32_t kMaxDataBytes = 0x7FFFFFFF;  // a length is signed

template <typename T>
T big_endian(const std::uint8_t* bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = value << 8 | bytes[i];
  return static_cast<T>(value);
}

}  // namespace

LogFile::LogFile(std::string path) : path_(std::move(path)) {
  descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) {
    throw SourceError(path_ + ": cannot be opened: " + std::strerror(errno));
  }
  if (!S_ISREG(status.st_mode)) {
    ::close(descriptor_);
    throw SourceError(path_ + ": is not a file");
  }
  size_bytes_ = static_cast<std::uint64_t>(status.st_size);
}

LogFile::~LogFile() { ::close(descriptor_); }

void LogFile::set_damage(const std::string& what) {
  damage_ = path_ + ": " + what + " at byte " + std::to_string(position_) + ", after " +
            std::to_string(events_) + " whole events";
}

bool LogFile::read(std::uint64_t offset, std::span<std::uint8_t> to) const {
  while (!to.empty()) {
    const ssize_t got = ::pread(descriptor_, to.data(), to.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    offset += static_cast<std::uint64_t>(got);
    to = to.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

std::optional<LogEvent> LogFile::next_event() {
  if (position_ == size_bytes_ || !damage_.empty()) return std::nullopt;
  std::array<std::uint8_t, kHeaderBytes> header{};
  if (!read(position_, header)) {
    set_damage("the log is truncated");
    return std::nullopt;
  }
  const auto channel_bytes = big_endian<std::uint32_t>(&header[20]);
  LogEvent event;
  event.number = big_endian<std::int64_t>(&header[4]);
  event.utime_us = big_endian<std::int64_t>(&header[12]);
  event.data_bytes = big_endian<std::uint32_t>(&header[24]);
  const bool is_event = big_endian<std::uint32_t>(header.data()) == kSyncWord &&
                        channel_bytes <= kMaxChannelBytes && event.data_bytes <= kMaxDataBytes;
  if (!is_event) {
    set_damage(events_ == 0 ? "not an LCM log" : "the log is damaged");
    return std::nullopt;
  }
  event.data_offset = position_ + kHeaderBytes + channel_bytes;
  event.channel.resize(channel_bytes);
  const std::span channel(reinterpret_cast<std::uint8_t*>(event.channel.data()), channel_bytes);
  const std::uint64_t end = event.data_offset + event.data_bytes;
  if (end > size_bytes_ || !read(position_ + kHeaderBytes, channel)) {
    set_damage("the log is truncated");
    return std::nullopt;
  }
  position_ = end;
  ++events_;
  return event;
}

bool LogMessageReader::fetch(std::uint64_t offset, std::span<std::uint8_t> to) {
  if (offset > event_.data_bytes || event_.data_bytes - offset < to.size()) return false;
  return log_.read(event_.data_offset + offset, to);
}

}  // namespace egomod
