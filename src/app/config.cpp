// SPDX-License-Identifier: Apache-2.0
#include "egomod/app/config.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <optional>
#include <sstream>

#include "option.hpp"

namespace egomod {
namespace {

template <typename... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <typename... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

// As short as it can be without changing the value, and never mistaken for an integer.
std::string text_of(double value) {
  std::array<char, 32> buffer{};
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  std::string text(buffer.data(), end);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

std::string short_text_of(double value) {
  const std::string text = text_of(value);
  return text.ends_with(".0") ? text.substr(0, text.size() - 2) : text;
}

std::string in_quotes(const std::string& text) {
  const toml::value<std::string> value(text);
  std::ostringstream stream;
  stream << toml::toml_formatter(value, toml::format_flags::none);
  return stream.str();
}

std::string joined(std::span<const std::string_view> names) {
  std::string text;
  for (const std::string_view name : names) {
    text += fmt::format("{}\"{}\"", text.empty() ? "" : ", ", name);
  }
  return text;
}

std::string value_of(const Option& option, Config& config) {
  return std::visit(
      Overloaded{
          [&](double& (*field)(Config&)) { return text_of(field(config)); },
          [&](bool& (*field)(Config&)) { return std::string(field(config) ? "true" : "false"); },
          [&](std::string& (*field)(Config&)) { return in_quotes(field(config)); },
          [&](const Choice& choice) {
            return fmt::format("\"{}\"",
                               choice.names[static_cast<std::size_t>(choice.get(config))]);
          },
          [&](auto* field) { return std::to_string(field(config)); },
      },
      option.field);
}

bool is_number(const Option& option) { return option.min < option.max; }

std::string range_of(const Option& option) {
  if (const auto* choice = std::get_if<Choice>(&option.field)) {
    return joined(choice->names);
  }
  if (!is_number(option)) {
    return {};
  }
  return fmt::format("{} to {}{}{}", short_text_of(option.min), short_text_of(option.max),
                     option.unit.empty() ? "" : " ", option.unit);
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

// The key that was meant, if one is near. So is the right one in the wrong section.
std::string advice_on(std::string_view key) {
  const std::string_view name = key.substr(key.rfind('.') + 1);
  const auto distance = [&](const Option& option) {
    const std::size_t elsewhere = option.name() == name ? 1 : name.size();
    return std::min(edit_distance(key, option.key), elsewhere);
  };
  const auto nearest = std::ranges::min_element(options(), {}, distance);
  if (distance(*nearest) <= std::max<std::size_t>(2, name.size() / 3)) {
    return fmt::format("did you mean {}?", nearest->key);
  }
  return "--dump-config shows every key";
}

const Option* find_option(std::string_view key) {
  const auto found = std::ranges::find(options(), key, &Option::key);
  return found == options().end() ? nullptr : &*found;
}

bool is_section(std::string_view key) {
  const std::string prefix = std::string(key) + '.';
  return std::ranges::any_of(options(),
                             [&](const Option& option) { return option.key.starts_with(prefix); });
}

[[noreturn]] void refuse(const std::string& where, std::string_view key, const std::string& why) {
  throw ConfigError(fmt::format("{}: {}: {}", where, key, why));
}

std::string wanted(const Option& option) {
  const std::string range = range_of(option);
  return std::visit(Overloaded{
                        [&](double& (*)(Config&)) { return "a number from " + range; },
                        [&](bool& (*)(Config&)) { return std::string("true or false"); },
                        [&](std::string& (*)(Config&)) { return std::string("a \"text\""); },
                        [&](const Choice&) { return "one of " + range; },
                        [&](auto*) { return "a whole number from " + range; },
                    },
                    option.field);
}

template <typename T>
std::optional<T> number_in_range(const Option& option, const std::optional<T>& value) {
  const bool inside = value && static_cast<double>(*value) >= option.min &&
                      static_cast<double>(*value) <= option.max;
  return inside ? value : std::nullopt;
}

bool assign(const Choice& choice, Config& config, const std::optional<std::string>& value) {
  const auto found = std::ranges::find(choice.names, value.value_or(""));
  if (found != choice.names.end()) {
    choice.set(config, static_cast<int>(found - choice.names.begin()));
  }
  return found != choice.names.end();
}

// `value` into the option's field; false: wrong type or out of range. NaN is in no range.
bool assign(const Option& option, Config& config, const toml::node& value) {
  const auto store = [&](auto* field, const auto& read) {
    if (read) {
      field(config) = static_cast<std::decay_t<decltype(field(config))>>(*read);
    }
    return read.has_value();
  };
  return std::visit(
      Overloaded{
          [&](double& (*field)(Config&)) {
            return store(field, number_in_range(option, value.value<double>()));
          },
          [&](bool& (*field)(Config&)) { return store(field, value.value_exact<bool>()); },
          [&](std::string& (*field)(Config&)) {
            return store(field, value.value_exact<std::string>());
          },
          [&](const Choice& choice) {
            return assign(choice, config, value.value_exact<std::string>());
          },
          [&](auto* field) {
            return store(field, number_in_range(option, value.value_exact<std::int64_t>()));
          },
      },
      option.field);
}

std::string position(const std::string& file, const toml::source_region& source) {
  return fmt::format("{}:{}:{}", file, source.begin.line, source.begin.column);
}

std::string shown(const toml::node& value) {
  std::ostringstream stream;
  stream << toml::toml_formatter(value, toml::format_flags::none);
  return stream.str();
}

void apply_value(Config& config, const std::string& where, const std::string& key,
                 const toml::node& value, ConfigOrigins* origins) {
  const Option* option = find_option(key);
  if (option == nullptr) {
    refuse(where, key, "unknown key; " + advice_on(key));
  }
  if (!assign(*option, config, value)) {
    refuse(where, key, "want " + wanted(*option) + ", not " + shown(value));
  }
  if (origins != nullptr) {
    (*origins)[key] = where;
  }
}

void apply_table(Config& config, const std::string& file, const std::string& prefix,
                 const toml::table& table, ConfigOrigins* origins) {
  for (const auto& [name, value] : table) {
    const std::string key = prefix + std::string(name.str());
    if (value.is_table() && is_section(key)) {
      apply_table(config, file, key + '.', *value.as_table(), origins);
    } else {
      apply_value(config, position(file, name.source()), key, value, origins);
    }
  }
}

// A folder opens as a file does, and reads as an empty one.
std::string read_text(const std::string& path) {
  std::ifstream file(path);
  if (!file || !std::filesystem::is_regular_file(path)) {
    throw ConfigError(path + ": is not a file that can be read; name a TOML file");
  }
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

toml::table parse(const std::string& text, const std::string& file) {
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw ConfigError(fmt::format("{}: {}", position(file, error.source()), error.description()));
  }
}

}  // namespace

void apply_file(Config& config, const std::string& path, ConfigOrigins* origins) {
  apply_table(config, path, "", parse(read_text(path), path), origins);
}

// Text needs no quotes on the command line.
void apply_setting(Config& config, std::string_view setting, ConfigOrigins* origins) {
  const std::string where = fmt::format("--set {}", setting);
  const std::size_t equals = setting.find('=');
  if (equals == std::string_view::npos) {
    throw ConfigError(where + ": want section.key=value");
  }
  const std::string key(setting.substr(0, equals));
  const std::string value(setting.substr(equals + 1));
  const Option* option = find_option(key);
  const bool is_text =
      option != nullptr && (std::holds_alternative<std::string& (*)(Config&)>(option->field) ||
                            std::holds_alternative<Choice>(option->field));
  const bool bare = is_text && !value.starts_with('"') && !value.starts_with('\'');
  const toml::table table = parse("value = " + (bare ? in_quotes(value) : value), where);
  if (table.size() != 1) {
    throw ConfigError(where + ": want one value");
  }
  apply_value(config, where, key, *table.get("value"), origins);
}

std::string choices_of_machine(const Config& config) {
  return fmt::format("up to {} tracks, kernels for {}", max_tracks(config.features),
                     name(instruction_set()));
}

std::string dump(const Config& config) {
  Config copy = config;
  std::string text;
  std::string_view section;
  for (const Option& option : options()) {
    if (option.section() != section) {
      section = option.section();
      text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", section);
    }
    const std::string range = range_of(option);
    text += fmt::format("# {}{}\n{} = {}\n", option.help,
                        range.empty() ? "" : fmt::format(" ({})", range), option.name(),
                        value_of(option, copy));
  }
  return text;
}

}  // namespace egomod
