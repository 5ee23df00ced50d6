// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "egomod/capture/capture_config.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomod/features/feature_tracker.hpp"
#include "egomod/moving_objects/moving_objects_config.hpp"
#include "egomod/pipeline/pipeline_config.hpp"
#include "egomod/publish/publish_config.hpp"

namespace egomod {

struct DaemonConfig {
  std::string source{};   // SPEC of --source
  std::string rig{};      // calibration file; empty: what the source brings along
  std::string lcm_url{};  // empty: LCM_DEFAULT_URL, else LCM's own default
  std::string record{};   // log to write; empty: none
  bool record_timing = false;
};

enum class LogLevel { kDebug, kInfo, kWarning, kError };

struct LoggingConfig {
  LogLevel level = LogLevel::kInfo;
  double repeat_s = 10.0;  // a warning that repeats is logged at most once in this time
};

// Everything that can be set, one struct a stage; the defaults are the structs' own.
struct Config {
  DaemonConfig daemon;
  CaptureConfig capture;
  FeaturesConfig features;
  EgomotionConfig egomotion;
  MovingObjectsConfig moving_objects;
  PublishConfig publish;
  PipelineConfig pipeline;
  LoggingConfig logging;
};

// Where each key that was set was set, as messages name it: "file:line:column", "--set ...".
using ConfigOrigins = std::map<std::string, std::string, std::less<>>;

// A configuration that is refused: names file, line, column and key, and what would be right.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Sets what the TOML file sets. Throws ConfigError.
void apply_file(Config& config, const std::string& path, ConfigOrigins* origins = nullptr);
// "section.key=value", as --set takes it. Throws ConfigError.
void apply_setting(Config& config, std::string_view setting, ConfigOrigins* origins = nullptr);
// What no single key shows to be wrong. Throws ConfigError.
void check(const Config& config, const ConfigOrigins& origins = {});
// That there is such a source, and that the rig file can be used. Throws ConfigError.
void check_source_and_rig(const Config& config, const ConfigOrigins& origins = {});
// What an option leaves to this machine, in words.
[[nodiscard]] std::string choices_of_machine(const Config& config);
// The whole configuration as a TOML file; a comment gives each key's meaning, unit and range.
[[nodiscard]] std::string dump(const Config& config);

// File of a preset: NAME among those that come with the program, or a path. Throws ConfigError that
// lists the presets there are.
[[nodiscard]] std::string find_preset(const std::string& name);

}  // namespace egomod
