// SPDX-License-Identifier: Apache-2.0
#include "egomod/app/command_line.hpp"

#include <CLI/CLI.hpp>
#include <array>

#include "egomod/app/version.hpp"
#include "egomod/publish/record_writer.hpp"
#include "record_check.hpp"

namespace egomod {
namespace {

struct Arguments {
  std::string config;
  std::string preset;
  std::vector<std::string> settings;
  // Named options in terms of --set: key and what was given.
  std::string source, rig, lcm_url, record, log_level;
  bool record_timing = false;
  bool single_thread = false;
  bool realtime = false;
  bool quiet = false;
  bool check = false;
  bool dump = false;
  bool version = false;
};

void declare(CLI::App& app, Arguments& a) {
  app.add_option("--config", a.config, "TOML file; --dump-config shows every key")
      ->type_name("FILE");
  app.add_option("--preset", a.preset, "Settings that come with the program, or a path")
      ->type_name("NAME");
  app.add_option("--rig", a.rig, "Calibration of the rig")->type_name("FILE");
  app.add_option("--source", a.source, "folder:DIR, log:FILE, lcm, sim[:WORLD]")->type_name("SPEC");
  app.add_option("--lcm-url", a.lcm_url, "The bus")->type_name("URL");
  app.add_option("--record", a.record, "LCM log to write, overwritten")->type_name("FILE");
  app.add_flag("--record-timing", a.record_timing, "Record the stages' times too");
  app.add_flag("--single-thread", a.single_thread, "All stages in order on one thread");
  app.add_flag("--realtime", a.realtime, "Replay as fast as recorded, late pairs are dropped");
  app.add_option("--set", a.settings, "Set one key of the configuration; may be repeated")
      ->type_name("SECTION.KEY=VALUE")
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--log-level", a.log_level, "debug, info, warning or error")->type_name("LEVEL");
  app.add_flag("--quiet", a.quiet, "Neither progress nor summary, warnings and errors only");
  app.add_flag("--check-config", a.check, "Check the configuration and exit");
  app.add_flag("--dump-config", a.dump, "Print the configuration as TOML and exit");
  app.add_flag("--version", a.version, "Print the version and what is built in, and exit");
  app.footer(
      "Exit codes: 0 end of the replay or asked to stop, 1 failed, 2 the command line is wrong, 78 "
      "the configuration is: a key, a source that this build does not have, the rig file, a record "
      "over what is read.");
}

void apply_named_texts(const Arguments& a, Config& config, ConfigOrigins& origins) {
  struct Text {
    const char* option;
    const char* key;
    std::string& value;
    const std::string& given;
  };
  DaemonConfig& daemon = config.daemon;
  for (const Text& text : {Text{"--source", "daemon.source", daemon.source, a.source},
                           Text{"--rig", "daemon.rig", daemon.rig, a.rig},
                           Text{"--lcm-url", "daemon.lcm_url", daemon.lcm_url, a.lcm_url},
                           Text{"--record", "daemon.record", daemon.record, a.record}}) {
    if (!text.given.empty()) {
      text.value = text.given;
      origins[text.key] = text.option;
    }
  }
}

Config config_from(const Arguments& a, ConfigOrigins& origins) {
  Config config;
  if (!a.preset.empty()) {
    apply_file(config, find_preset(a.preset), &origins);
  }
  if (!a.config.empty()) {
    apply_file(config, a.config, &origins);
  }
  for (const std::string& setting : a.settings) {
    apply_setting(config, setting, &origins);
  }
  apply_named_texts(a, config, origins);
  if (!a.log_level.empty()) {
    apply_setting(config, "logging.level=" + a.log_level);
  } else if (a.quiet) {
    config.logging.level = std::max(config.logging.level, LogLevel::kWarning);
  }
  config.daemon.record_timing |= a.record_timing;
  config.pipeline.single_thread |= a.single_thread;
  config.pipeline.realtime |= a.realtime;
  check(config, origins);
  return config;
}

// The configuration's own files are known here only.
void check_record(const Arguments& a, const Config& config) {
  const std::array files{a.config, a.preset.empty() ? a.preset : find_preset(a.preset)};
  try {
    refuse_record_over_inputs(config.daemon, files);
  } catch (const RecordError& error) {
    throw ConfigError(error.what());
  }
}

Command command_from(const Arguments& a) {
  if (a.version) {
    return {.action = Command::Action::kPrint, .text = version_text()};
  }
  ConfigOrigins origins;
  Command command{.config = config_from(a, origins), .quiet = a.quiet};
  if (a.dump) {
    command.action = Command::Action::kPrint;
    command.text = dump(command.config);
    return command;
  }
  check_source_and_rig(command.config, origins);
  check_record(a, command.config);
  if (a.check) {
    command.action = Command::Action::kPrint;
    command.text =
        "the configuration is fine; on this machine: " + choices_of_machine(command.config) + "\n";
  } else if (command.config.daemon.source.empty()) {
    throw ConfigError("no source; give --source SPEC or daemon.source, --help says more");
  }
  return command;
}

Command refusal(const std::string& text, ExitCode exit_code) {
  return {.action = Command::Action::kRefuse, .text = text, .exit_code = exit_code};
}

}  // namespace

Command parse_command_line(int argc, const char* const* argv) {
  CLI::App app("Egomotion and moving objects from a moving stereo rig, in real time", "egomodd");
  Arguments arguments;
  declare(app, arguments);
  try {
    app.parse(argc, argv);
    return command_from(arguments);
  } catch (const CLI::CallForHelp&) {
    return {.action = Command::Action::kPrint, .text = app.help()};
  } catch (const CLI::ParseError& error) {
    return refusal("egomodd: " + std::string(error.what()) + "; --help lists the options\n",
                   kExitUsage);
  } catch (const ConfigError& error) {
    return refusal("egomodd: " + std::string(error.what()) + "\n", kExitConfig);
  }
}

}  // namespace egomod
