// SPDX-License-Identifier: Apache-2.0
#include "capture/text_file.hpp"

#include <charconv>
#include <cmath>
#include <fstream>

#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

constexpr std::string_view kSpace = " \t\r\n\v\f";

double parse_number(std::string_view token, const std::string& where) {
  const std::string_view digits = token.starts_with('+') ? token.substr(1) : token;
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || end != digits.data() + digits.size()) {
    throw SourceError(where + ": '" + shown(token) + "' is not a number");
  }
  if (!std::isfinite(value)) {
    throw SourceError(where + ": '" + shown(token) + "' is not finite");
  }
  return value;
}

}  // namespace

std::string at(const std::filesystem::path& file, int line) {
  return file.string() + ":" + std::to_string(line);
}

std::string shown(std::string_view text) {
  constexpr std::size_t kMaxLength = 60;
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string safe;
  for (const char letter : text.substr(0, kMaxLength)) {
    const auto byte = static_cast<unsigned char>(letter);
    if (byte >= 0x20 && byte < 0x7F) {
      safe += letter;
    } else {
      safe += {'\\', 'x', kHex[byte >> 4U], kHex[byte & 0xFU]};
    }
  }
  return text.size() > kMaxLength ? safe + "..." : safe;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

std::vector<TextLine> read_lines(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw SourceError(file.string() + ": cannot be read");
  std::vector<TextLine> lines;
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    if (const std::string_view content = trimmed(text); !content.empty()) {
      lines.push_back({number, std::string(content)});
    }
  }
  if (stream.bad()) throw SourceError(file.string() + ": reading failed");
  return lines;
}

std::vector<double> parse_numbers(std::string_view text, const std::string& where) {
  std::vector<double> numbers;
  for (std::string_view rest = trimmed(text); !rest.empty();) {
    const std::size_t length = std::min(rest.find_first_of(kSpace), rest.size());
    numbers.push_back(parse_number(rest.substr(0, length), where));
    rest = trimmed(rest.substr(length));
  }
  return numbers;
}

long long parse_integer(std::string_view text, const std::string& where) {
  long long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    throw SourceError(where + ": '" + shown(text) + "' is not a whole number");
  }
  return value;
}

}  // namespace egomod
