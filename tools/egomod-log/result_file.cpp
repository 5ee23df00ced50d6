// SPDX-License-Identifier: Apache-2.0
#include "result_file.hpp"

#include <utility>

namespace egomod::log {
namespace {

namespace fs = std::filesystem;

// A folder or a device cannot be replaced; whoever opens it says what is wrong with that.
bool is_replaceable(const fs::path& target) {
  std::error_code ignored;
  return !fs::exists(target, ignored) || fs::is_regular_file(target, ignored);
}

}  // namespace

ResultFile::ResultFile(fs::path target) : target_(std::move(target)), path_(target_) {
  if (is_replaceable(target_)) path_ += ".part";
}

ResultFile::~ResultFile() {
  std::error_code ignored;
  if (!is_kept_ && path_ != target_) fs::remove(path_, ignored);
}

void ResultFile::keep() {
  is_kept_ = true;
  if (path_ == target_) return;
  std::error_code error;
  fs::rename(path_, target_, error);
  if (!error) return;
  is_kept_ = false;
  throw OutputError(target_.string() + ": cannot be written: " + error.message());
}

}  // namespace egomod::log
