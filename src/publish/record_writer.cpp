// SPDX-License-Identifier: Apache-2.0
#include "egomod/publish/record_writer.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <utility>

namespace egomod {

struct RecordWriter::Log {
  explicit Log(const std::string& path) : file(path, "w") {}
  lcm::LogFile file;
  lcm::LogEvent event{};
};

RecordWriter::RecordWriter(std::string path) : path_(std::move(path)) {
  errno = 0;
  log_ = std::make_unique<Log>(path_);
  if (!log_->file.good()) fail(errno);
}

RecordWriter::~RecordWriter() = default;

void RecordWriter::write(const EncodedMessage& message) {
  lcm::LogEvent& event = log_->event;
  event.channel = message.channel;
  event.timestamp = message.utime_us;
  event.datalen = static_cast<int32_t>(message.bytes.size());
  // LogEvent has no const view; writeEvent only reads.
  event.data = const_cast<std::uint8_t*>(message.bytes.data());
  errno = 0;
  if (log_->file.writeEvent(&event) != 0) fail(errno);
}

void RecordWriter::flush() {
  errno = 0;
  std::FILE* const file = log_->file.getFilePtr();
  if (std::fflush(file) != 0 || std::ferror(file) != 0) fail(errno);
}

void RecordWriter::fail(int error_number) {
  if (first_error_ == 0) first_error_ = error_number;
  const std::string reason = first_error_ == 0 ? "is the disk full?" : std::strerror(first_error_);
  throw RecordError("record " + path_ + ": cannot be written (" + reason +
                    "); name a file in a folder that exists, may be written and has room");
}

}  // namespace egomod
