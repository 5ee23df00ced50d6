// SPDX-License-Identifier: Apache-2.0
#include "logging.hpp"

#include <fmt/format.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <cctype>
#include <cstdlib>
#include <memory>

namespace egomod {
namespace {

// sd-daemon(3): a line that begins with <N> has syslog priority N.
class JournalPriority : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&,
              spdlog::memory_buf_t& destination) override {
    const std::string_view priority = message.level >= spdlog::level::err    ? "<3>"
                                      : message.level == spdlog::level::warn ? "<4>"
                                      : message.level == spdlog::level::info ? "<6>"
                                                                             : "<7>";
    destination.append(priority.data(), priority.data() + priority.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<JournalPriority>();
  }
};

spdlog::level::level_enum spdlog_level(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
  }
  return spdlog::level::info;
}

// Figures change from one warning to the next of the same kind.
std::string kind_of(const std::string& text) {
  std::string kind = text;
  for (char& letter : kind) {
    letter = std::isdigit(static_cast<unsigned char>(letter)) != 0 ? '#' : letter;
  }
  return kind;
}

}  // namespace

void set_up_logging(LogLevel level) {
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  if (std::getenv("JOURNAL_STREAM") != nullptr) {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "egomodd", std::make_shared<spdlog::sinks::stderr_sink_mt>()));
    formatter->add_flag<JournalPriority>('*').set_pattern("%*%v");
  } else {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "egomodd", std::make_shared<spdlog::sinks::stderr_color_sink_mt>()));
    formatter->set_pattern("%H:%M:%S.%e %^%l%$: %v");
  }
  spdlog::set_formatter(std::move(formatter));
  spdlog::set_level(spdlog_level(level));
}

std::string WarningLimiter::passed(const std::string& text, Clock::time_point now) {
  const std::string kind = kind_of(text);
  const bool known = seen_.contains(kind);
  const auto [entry, is_new] =
      seen_.try_emplace(known || seen_.size() < kMaxKinds ? kind : std::string(), Seen{now, 0});
  Seen& seen = entry->second;
  if (!is_new && std::chrono::duration<double>(now - seen.last).count() < repeat_s_) {
    ++seen.held_back;
    return {};
  }
  const std::uint64_t held_back = std::exchange(seen.held_back, 0);
  seen.last = now;
  return held_back == 0 ? text : fmt::format("{} ({} more like this before)", text, held_back);
}

void WarningLimiter::warn(const std::string& text, Clock::time_point now) {
  if (const std::string line = passed(text, now); !line.empty()) {
    spdlog::warn("{}", line);
  }
}

}  // namespace egomod
