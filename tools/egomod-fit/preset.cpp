// SPDX-License-Identifier: Apache-2.0
#include "preset.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "labels.hpp"
#include "result_file.hpp"

namespace egomod::fit {
namespace {

constexpr const char* kTable = "[moving_objects]";
constexpr const char* kBlanks = " \t\r";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// Of a line "name = value  # comment": name and value; both empty otherwise.
struct Assignment {
  std::string name, value;
};
std::string stripped(const std::string& text) {
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}
Assignment assignment_of(const std::string& line) {
  const auto equals = line.find('=');
  if (equals == std::string::npos || stripped(line).front() == '#') return {};
  const auto comment = line.find('#', equals);
  return {stripped(line.substr(0, equals)),
          stripped(line.substr(equals + 1,
                               comment == std::string::npos ? comment : comment - equals - 1))};
}

bool begins_table(const std::string& line) { return stripped(line).starts_with('['); }

// TOML has more ways to spell a table and its keys, which would be set twice.
void require_plain_spelling(const std::vector<std::string>& lines) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::string bare = stripped(lines[i]);
    const bool is_plain = bare.starts_with(kTable);
    std::erase_if(bare, [](char c) { return c == ' ' || c == '\t' || c == '"' || c == '\''; });
    const bool is_ours = bare.starts_with(kTable) || bare.starts_with("moving_objects.") ||
                         bare.starts_with("moving_objects=");
    const bool has_quoted_name =
        assignment_of(lines[i]).name.find_first_of("\"'") != std::string::npos;
    if ((is_ours && !is_plain) || has_quoted_name)
      throw InputError(
          fmt::format("line {}: {}: write the table as {} and its keys below it, "
                      "without quotes",
                      i + 1, stripped(lines[i]), kTable));
  }
}

std::string line_of(const FittedKey& key) {
  return fmt::format("{} = {:.6g}  # fitted by egomod-fit", key.name, key.value);
}

std::string text_of_file(const std::string& path) {
  std::ifstream file(path);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file.is_open() || file.bad()) throw InputError(path + ": cannot be read");
  return text;
}

std::filesystem::path target_of(const Options& options) {
  const std::filesystem::path folder = options.output;
  if (options.preset.empty()) return folder / "moving_objects.toml";
  std::filesystem::path target = folder / std::filesystem::path(options.preset).filename();
  std::error_code error;
  if (std::filesystem::equivalent(target, options.preset, error)) {
    throw InputError(target.string() + ": would be replaced; give another folder with --output");
  }
  return target;
}

}  // namespace

std::string with_keys(const std::string& text, const std::vector<FittedKey>& keys,
                      std::string& changes) {
  std::vector<std::string> lines = lines_of(text);
  require_plain_spelling(lines);
  std::size_t begin = 0;
  while (begin < lines.size() && !stripped(lines[begin]).starts_with(kTable)) ++begin;
  if (begin == lines.size()) {
    if (!lines.empty()) lines.emplace_back();
    lines.emplace_back(kTable);
    begin = lines.size() - 1;
  }
  std::size_t end = begin + 1;  // behind the table's last assignment
  for (std::size_t i = end; i < lines.size() && !begins_table(lines[i]); ++i) {
    if (!assignment_of(lines[i]).name.empty()) end = i + 1;
  }
  for (const FittedKey& key : keys) {
    std::size_t at = begin + 1;
    while (at < end && assignment_of(lines[at]).name != key.name) ++at;
    const bool is_there = at < end;
    changes += fmt::format("{:<20} {:.6g}  (was {})\n", key.name, key.value,
                           is_there ? assignment_of(lines[at]).value : "not set");
    if (is_there) {
      lines[at] = line_of(key);
    } else {
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(end++), line_of(key));
    }
  }
  std::string result;
  for (const std::string& line : lines) result += line + '\n';
  return result;
}

void write_preset(const Options& options, const std::vector<FittedKey>& keys) {
  const std::filesystem::path target = target_of(options);
  std::string changes;
  std::string text = options.preset.empty() ? "" : text_of_file(options.preset);
  try {
    text = with_keys(text, keys, changes);
  } catch (const InputError& error) {
    throw InputError(options.preset + ": " + error.what());
  }
  log::ResultFile result(target);
  std::ofstream file(result.path());
  file << text;
  if (!file.flush()) throw InputError(target.string() + ": cannot be written");
  result.keep();
  std::printf("%swrote %s\n", options.preset.empty() ? "" : changes.c_str(), target.c_str());
}

}  // namespace egomod::fit
