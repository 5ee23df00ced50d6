// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace egomod::eval {

// A new folder that goes with the object.
class TemporaryFolder {
 public:
  // Throws InputError.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace egomod::eval
