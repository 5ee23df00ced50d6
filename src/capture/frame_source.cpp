// SPDX-License-Identifier: Apache-2.0
#include "egomod/capture/frame_source.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "capture/rig_file.hpp"
#include "capture/sim_source.hpp"
#include "capture/sources.hpp"

namespace egomod {
namespace {

enum class Argument { kNone, kOptional, kRequired };

struct Kind {
  std::string_view name;
  Argument has = Argument::kNone;
  std::string_view argument{};
};

constexpr Kind kKinds[] = {{"folder", Argument::kRequired, "DIR"},
                           {"log", Argument::kRequired, "FILE"},
                           {"lcm"},
                           {"sim", Argument::kOptional, "WORLD"}};

struct Spec {
  explicit Spec(const std::string& text)
      : name(text.substr(0, text.find(':'))),
        has_argument(name.size() < text.size()),
        argument(has_argument ? text.substr(name.size() + 1) : "") {}

  std::string name;
  bool has_argument;
  std::string argument;
};

bool fits(const Spec& spec, const Kind& kind) {
  if (spec.name != kind.name) return false;
  if (spec.has_argument) return kind.has != Argument::kNone && !spec.argument.empty();
  return kind.has != Argument::kRequired;
}

std::string shown(const Kind& kind) {
  const std::string argument = ":" + std::string(kind.argument);
  switch (kind.has) {
    case Argument::kNone:
      break;
    case Argument::kOptional:
      return std::string(kind.name) + "[" + argument + "]";
    case Argument::kRequired:
      return std::string(kind.name) + argument;
  }
  return std::string(kind.name);
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
  if (std::ranges::none_of(kKinds, [&](const Kind& kind) { return fits(spec, kind); })) {
    throw SourceError("source '" + text + "' is unknown or not built in; " + available());
  }
}

void check_rig(const std::string& rig_file) { static_cast<void>(read_rig_file(rig_file)); }

std::unique_ptr<FrameSource> open_source(const std::string& text, const CaptureConfig& config,
                                         const std::string& rig_file, const BusAddress& lcm_url,
                                         bool realtime) {
  check_source(text);
  const Spec spec(text);
  if (spec.name == "folder") return open_folder_source(spec.argument, config, rig_file);
  if (spec.name == "log") return open_log_source(spec.argument, config, rig_file);
  if (spec.name == "lcm") return open_lcm_source(lcm_url, config, rig_file);
  return open_sim_source({.program = find_simulator(),
                          .world = spec.argument,
                          .rig_file = rig_file,
                          .lcm_url = lcm_url.url(),
                          .realtime = realtime},
                         config);
}

}  // namespace egomod
