// SPDX-License-Identifier: Apache-2.0
#include "record_check.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "egomod/publish/record_writer.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 3;  // mav0/cam0/data/*.png

// What sequences are made of; an earlier record beside them may be overwritten.
bool is_of_a_sequence(const fs::path& file) {
  constexpr std::array<std::string_view, 6> kEndings{".png",  ".txt", ".csv",
                                                     ".yaml", ".yml", ".toml"};
  return std::ranges::find(kEndings, file.extension().string()) != kEndings.end();
}

bool is_same(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored);
}

bool is_in_sequence(const fs::path& folder, const fs::path& record) {
  std::error_code error;
  fs::recursive_directory_iterator file(folder, fs::directory_options::follow_directory_symlink,
                                        error);
  for (; !error && file != fs::recursive_directory_iterator(); file.increment(error)) {
    if (file.depth() >= kDeepest) file.disable_recursion_pending();
    if (is_of_a_sequence(file->path()) && is_same(file->path(), record)) return true;
  }
  return false;
}

// What of the source the record is; empty if it is nothing of it.
std::string part_of_source(const DaemonConfig& daemon) {
  const std::string_view source = daemon.source;
  const std::string_view path = source.substr(std::min(source.find(':'), source.size() - 1) + 1);
  if (source.starts_with("log:") && is_same(path, daemon.record)) return "the log that is read";
  if (source.starts_with("sim:") && is_same(path, daemon.record)) return "the world that is read";
  const bool is_in_folder = source.starts_with("folder:") && is_in_sequence(path, daemon.record);
  return is_in_folder ? "a file of the sequence that is read" : "";
}

}  // namespace

void refuse_record_over_inputs(const DaemonConfig& daemon,
                               std::span<const std::string> configuration) {
  std::error_code ignored;
  if (!fs::is_regular_file(daemon.record, ignored)) return;
  std::string what = daemon.source.empty() ? "" : part_of_source(daemon);
  if (is_same(daemon.rig, daemon.record)) what = "the rig file";
  for (const std::string& file : configuration) {
    if (is_same(file, daemon.record)) what = "the configuration file";
  }
  if (what.empty()) return;
  throw RecordError("record " + daemon.record + ": is " + what +
                    ", and would be overwritten; name another file");
}

}  // namespace egomod
