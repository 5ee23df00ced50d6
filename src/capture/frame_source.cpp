// SPDX-License-Identifier: Apache-2.0
#include "egomod/capture/frame_source.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "capture/rig_file.hpp"
#include "capture/sources.hpp"

namespace egomod {
namespace {

struct Kind {
  std::string_view name;
  std::string_view argument;  // that must follow it; empty: none may
};

constexpr Kind kKinds[] = {{"folder", "DIR"}, {"log", "FILE"}, {"lcm", ""}};

struct Spec {
  explicit Spec(const std::string& text)
      : name(text.substr(0, text.find(':'))),
        has_argument(name.size() < text.size()),
        argument(has_argument ? text.substr(name.size() + 1) : "") {}

  std::string name;
  bool has_argument;
  std::string argument;
};

std::string shown(const Kind& kind) {
  return std::string(kind.name) + (kind.argument.empty() ? "" : ":") + std::string(kind.argument);
}

std::string available() {
  std::string text = "this build has ";
  for (const Kind& kind : kKinds) {
    const bool is_last = &kind == std::prev(std::end(kKinds));
    text += (&kind == std::begin(kKinds) ? "" : is_last ? " and " : ", ") + shown(kind);
  }
  return text;
}

}  // namespace

void check_source(const std::string& text) {
  const Spec spec(text);
  const auto kind = std::ranges::find(kKinds, spec.name, &Kind::name);
  const bool fits = kind != std::end(kKinds) && kind->argument.empty() != spec.has_argument;
  if (!fits || spec.has_argument == spec.argument.empty()) {
    throw SourceError("source '" + text + "' is unknown or not built in; " + available());
  }
}

void check_rig(const std::string& rig_file) { static_cast<void>(read_rig_file(rig_file)); }

std::unique_ptr<FrameSource> open_source(const std::string& text, const CaptureConfig& config,
                                         const std::string& rig_file, const BusAddress& lcm_url) {
  check_source(text);
  const Spec spec(text);
  if (spec.name == "folder") return open_folder_source(spec.argument, config, rig_file);
  if (spec.name == "log") return open_log_source(spec.argument, config, rig_file);
  return open_lcm_source(lcm_url, config, rig_file);
}

}  // namespace egomod
