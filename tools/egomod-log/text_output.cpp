// SPDX-License-Identifier: Apache-2.0
#include "text_output.hpp"

#include <cerrno>
#include <cstring>

namespace egomod::log {

TextOutput::TextOutput(std::filesystem::path path)
    : path_(std::move(path)), result_(path_), file_(std::fopen(result_.path().c_str(), "w")) {
  if (!file_) fail();
}

void TextOutput::write(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) fail();
}

void TextOutput::close() {
  if (std::fclose(file_.release()) != 0) fail();
  result_.keep();
}

void TextOutput::fail() const {
  throw OutputError(fmt::format("{}: cannot be written: {}", path_.string(), std::strerror(errno)));
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder)) {
    throw OutputError(fmt::format("{}: is no folder and cannot be made one: {}", folder.string(),
                                  error ? error.message() : "a file is in the way"));
  }
}

}  // namespace egomod::log
