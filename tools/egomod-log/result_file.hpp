// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace egomod::log {

// A file that cannot be written: names it and the system's reason.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A file that is there whole or not at all: it is written as `target`.part and renamed at the end.
// What is no plain file, such as /dev/stdout, is written in place.
class ResultFile {
 public:
  explicit ResultFile(std::filesystem::path target);
  ResultFile(const ResultFile&) = delete;
  ResultFile& operator=(const ResultFile&) = delete;
  // Removes what was not kept.
  ~ResultFile();

  // Where to write.
  [[nodiscard]] std::string path() const { return path_.string(); }
  // All is written. Throws OutputError.
  void keep();

 private:
  std::filesystem::path target_;
  std::filesystem::path path_;
  bool is_kept_ = false;
};

}  // namespace egomod::log
