// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "egomod/publish/encoded_message.hpp"

namespace egomod {

// A record that cannot be written: names the file, the system's reason and the remedy.
class RecordError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Writes an LCM log; event time = the message's utime. Threads: one caller.
class RecordWriter {
 public:
  // Overwrites `path`. Throws RecordError.
  explicit RecordWriter(std::string path);
  RecordWriter(const RecordWriter&) = delete;
  RecordWriter& operator=(const RecordWriter&) = delete;
  ~RecordWriter();

  // Throws RecordError; what was written before is whole.
  void write(const EncodedMessage& message);
  // Everything is with the system. Throws RecordError.
  void flush();

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  struct Log;  // keeps LCM's headers out

  [[noreturn]] void fail(int error_number);

  std::string path_;
  int first_error_ = 0;  // errno of the first failure: a later one may have lost it
  std::unique_ptr<Log> log_;
};

}  // namespace egomod
