// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "result_file.hpp"

namespace egomod::log {

// A text file, overwritten at the end; nothing gets lost without an error.
class TextOutput {
 public:
  // Throws OutputError.
  explicit TextOutput(std::filesystem::path path);

  template <typename... Values>
  void print(fmt::format_string<Values...> format, Values&&... values) {
    write(fmt::format(format, std::forward<Values>(values)...));
  }
  // The file is there now, whole. Throws OutputError.
  void close();

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  void write(const std::string& text);
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  ResultFile result_;
  std::unique_ptr<std::FILE, Close> file_;
};

// Creates the folder if it is not there. Throws OutputError.
void make_folder(const std::filesystem::path& folder);

}  // namespace egomod::log
