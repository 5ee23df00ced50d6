// SPDX-License-Identifier: Apache-2.0
#include "egomod/app/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <type_traits>
#include <utility>

#include "option.hpp"

namespace egomod {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string read(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class ConfigFile : public ::testing::Test {
 protected:
  std::string write(const std::string& text) const {
    std::ofstream(file_) << text;
    return file_;
  }
  std::string error_of(const std::string& text) const {
    Config config;
    try {
      apply_file(config, write(text));
    } catch (const ConfigError& error) {
      const std::string what = error.what();
      return what.starts_with(file_ + ":") ? what.substr(file_.size() + 1) : what;
    }
    return "no error";
  }
  void TearDown() override { std::filesystem::remove(file_); }

  std::string file_ = ::testing::TempDir() + "egomod_config_test_" +
                      ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".toml";
};

// Regenerate with `egomodd --dump-config` after the licence line.
TEST_F(ConfigFile, the_sample_is_the_dump_of_the_defaults) {
  EXPECT_EQ(read(EGOMOD_CONFIG_DIR "/egomod.toml"),
            "# SPDX-License-Identifier: Apache-2.0\n" + dump(Config{}));
}

TEST_F(ConfigFile, a_dump_reads_back_as_the_same_configuration) {
  Config config;
  config.daemon.source = "folder:a \"quoted\" \\ name";
  config.capture.max_rate_hz = 1.0 / 3.0;
  config.pipeline.slots = 7;
  config.pipeline.realtime = true;
  config.egomotion.ransac.seed = 4294967295U;
  config.egomotion.method = EgomotionMethod::kSigmaPointKalmanFilter;
  Config again;
  apply_file(again, write(dump(config)));
  EXPECT_EQ(dump(again), dump(config));
  EXPECT_EQ(again.daemon.source, config.daemon.source);
  EXPECT_EQ(again.capture.max_rate_hz, config.capture.max_rate_hz);
  EXPECT_EQ(again.egomotion.ransac.seed, 4294967295U);
  EXPECT_EQ(again.egomotion.method, EgomotionMethod::kSigmaPointKalmanFilter);
}

TEST_F(ConfigFile, sets_what_it_names_and_leaves_the_rest) {
  Config config;
  config.pipeline.slots = 9;
  apply_file(config, write("[capture]\nmax_rate_hz = 5\n[egomotion]\nmethod = \"ispkf\"\n"
                           "ransac.max_samples = 7\n"));
  EXPECT_EQ(config.capture.max_rate_hz, 5.0);
  EXPECT_EQ(config.egomotion.method, EgomotionMethod::kSigmaPointKalmanFilter);
  EXPECT_EQ(config.egomotion.ransac.max_samples, 7);
  EXPECT_EQ(config.pipeline.slots, 9);
}

TEST_F(ConfigFile, an_unknown_key_is_refused_with_its_place_and_the_nearest_key) {
  EXPECT_EQ(error_of("# comment\n[capture]\n  max_rate_h = 5\n"),
            "3:3: capture.max_rate_h: unknown key; did you mean capture.max_rate_hz?");
  EXPECT_EQ(error_of("[features]\nmax_rate_hz = 5\n"),
            "2:1: features.max_rate_hz: unknown key; did you mean capture.max_rate_hz?");
}

TEST_F(ConfigFile, an_unknown_key_far_from_all_others_suggests_none) {
  EXPECT_EQ(error_of("[capture]\nbrightness = 5\n"),
            "2:1: capture.brightness: unknown key; --dump-config shows every key");
  EXPECT_EQ(error_of("[publish]\nslot = 5\n"),
            "2:1: publish.slot: unknown key; --dump-config shows every key")
      << "another section's key must be named exactly";
  EXPECT_EQ(error_of("[publish]\nslots = 5\n"),
            "2:1: publish.slots: unknown key; did you mean pipeline.slots?");
}

TEST_F(ConfigFile, an_unknown_section_is_refused) {
  EXPECT_THAT(error_of("[camera]\nfps = 30\n"), HasSubstr("camera: unknown key"));
  EXPECT_THAT(error_of("slots = 8\n"),
              StartsWith("1:1: slots: unknown key; did you mean pipeline"));
}

TEST_F(ConfigFile, a_wrong_type_is_refused_with_its_place) {
  EXPECT_EQ(error_of("[capture]\nmax_rate_hz = \"fast\"\n"),
            "2:1: capture.max_rate_hz: want a number from 0 to 1000 Hz, not \"fast\"");
  EXPECT_THAT(error_of("[capture]\nmax_rate_hz = true\n"), HasSubstr("want a number"));
  EXPECT_THAT(error_of("[pipeline]\nslots = 8.5\n"),
              HasSubstr("want a whole number from 6 to 256"));
  EXPECT_THAT(error_of("[pipeline]\nrealtime = 1\n"), HasSubstr("want true or false, not 1"));
  EXPECT_THAT(error_of("[daemon]\nsource = 3\n"), HasSubstr("want a \"text\""));
  EXPECT_THAT(error_of("capture = 3\n"), HasSubstr("capture: unknown key"));
}

TEST_F(ConfigFile, a_value_out_of_range_is_refused_with_its_place) {
  EXPECT_EQ(error_of("[pipeline]\n\nslots = 1000\n"),
            "3:1: pipeline.slots: want a whole number from 6 to 256 frames, not 1000");
  EXPECT_THAT(error_of("[capture]\nmax_rate_hz = nan\n"), HasSubstr("2:1: capture.max_rate_hz"));
  EXPECT_THAT(error_of("[capture]\nmax_rate_hz = inf\n"), HasSubstr("2:1: capture.max_rate_hz"));
  EXPECT_EQ(error_of("[egomotion]\nmethod = \"gauss\"\n"),
            "2:1: egomotion.method: want one of \"ispkf\", \"gauss_newton\", not \"gauss\"");
}

TEST_F(ConfigFile, what_is_not_toml_is_refused_with_its_place) {
  EXPECT_THAT(error_of("[capture]\nmax_rate_hz == 5\n"), StartsWith("2:"));
}

TEST_F(ConfigFile, a_missing_file_and_a_folder_are_refused_by_name) {
  for (const std::string path : {"/nowhere/egomod.toml", EGOMOD_CONFIG_DIR}) {
    Config config;
    try {
      apply_file(config, path);
      FAIL() << path;
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), StartsWith(path + ": is not a file that can be read"));
    }
  }
}

TEST(ConfigSetting, takes_text_with_and_without_quotes) {
  Config config;
  apply_setting(config, "daemon.source=folder:a=b");
  EXPECT_EQ(config.daemon.source, "folder:a=b");
  apply_setting(config, "daemon.source=\"lcm\"");
  EXPECT_EQ(config.daemon.source, "lcm");
  apply_setting(config, "egomotion.method=ispkf");
  EXPECT_EQ(config.egomotion.method, EgomotionMethod::kSigmaPointKalmanFilter);
  apply_setting(config, "capture.max_rate_hz=2.5");
  EXPECT_EQ(config.capture.max_rate_hz, 2.5);
  apply_setting(config, "daemon.source=");
  EXPECT_EQ(config.daemon.source, "");
}

TEST(ConfigSetting, refuses_what_a_file_would_not_do) {
  Config config;
  for (const char* setting : {"capture.max_rate_hz", "capture.max_rate_hz=", "pipeline.slot=8",
                              "pipeline.slots=8\nx=1", "pipeline.slots=1", "=3", "egomotion=1"}) {
    EXPECT_THROW(apply_setting(config, setting), ConfigError) << setting;
  }
}

TEST(ConfigCheck, refuses_what_no_single_key_shows) {
  Config config;
  EXPECT_NO_THROW(check(config));
  config.pipeline.cpus = "1,2";
  EXPECT_THROW(check(config), ConfigError);
  config = {};
  config.moving_objects.lag_s = 5.0;
  EXPECT_THROW(check(config), ConfigError);
  config = {};
  config.capture.left_channel = "LEFT";
  EXPECT_THROW(check(config), ConfigError);
}

TEST(ConfigCheck, refuses_too_few_tracks_but_leaves_the_number_to_the_machine_at_zero) {
  Config config;
  EXPECT_EQ(config.features.max_tracks, 0);
  EXPECT_NO_THROW(check(config));
  config.features.max_tracks = 16;
  EXPECT_NO_THROW(check(config));
  config.features.max_tracks = 15;
  EXPECT_THROW(check(config), ConfigError);
}

TEST(ConfigCheck, refuses_an_instruction_set_that_is_none) {
  setenv("EGOMOD_INSTRUCTION_SET", "avx9", 1);
  EXPECT_THROW(check(Config{}), ConfigError);
  setenv("EGOMOD_INSTRUCTION_SET", "baseline", 1);
  EXPECT_NO_THROW(check(Config{}));
  unsetenv("EGOMOD_INSTRUCTION_SET");
}

TEST(ConfigCheck, tells_what_is_left_to_the_machine) {
  Config config;
  setenv("EGOMOD_INSTRUCTION_SET", "baseline", 1);
  EXPECT_EQ(choices_of_machine(config), "up to 550 tracks, kernels for baseline");
  unsetenv("EGOMOD_INSTRUCTION_SET");
  config.features.max_tracks = 77;
  EXPECT_THAT(choices_of_machine(config), StartsWith("up to 77 tracks"));
}

class ConfigCheckOfFile : public ConfigFile {
 protected:
  // Without the file's name.
  std::string refusal_of(const std::string& text) const {
    Config config;
    ConfigOrigins origins;
    apply_file(config, write(text), &origins);
    try {
      check(config, origins);
    } catch (const ConfigError& error) {
      const std::string what = error.what();
      return what.starts_with(file_ + ":") ? what.substr(file_.size() + 1) : what;
    }
    return "no error";
  }
};

TEST_F(ConfigCheckOfFile, names_the_place_of_what_only_several_keys_show) {
  EXPECT_THAT(refusal_of("[pipeline]\n\ncpus = \"a\"\n"),
              StartsWith("3:1: pipeline.cpus: want one CPU number or 5"));
  EXPECT_EQ(refusal_of("[moving_objects]\nmax_lag_s = 0.5\nlag_s = 5\n"),
            "3:1: moving_objects.lag_s: want min_lag_s <= lag_s <= max_lag_s, not 0.2 <= 5 <= 0.5");
  EXPECT_THAT(refusal_of("[moving_objects]\nmin_lag_s = 9\n"),
              StartsWith("2:1: moving_objects.min_lag_s: want"));
  EXPECT_THAT(refusal_of("[capture]\nright_channel = \"R\"\n"),
              StartsWith("2:1: capture.right_channel: want both"));
  EXPECT_THAT(refusal_of("[capture]\nleft_channel = \"A\"\nright_channel = \"A\"\n"),
              StartsWith("2:1: capture.left_channel: left_channel and right_channel are both"));
}

TEST_F(ConfigCheckOfFile, refuses_to_publish_images_where_the_source_reads_them) {
  const std::string source = "[daemon]\nsource = \"lcm\"\n";
  const std::string images = "[publish]\nimages = \"jpeg\"\n";
  EXPECT_THAT(refusal_of(source + images), StartsWith("4:1: publish.images: the source lcm reads"));
  EXPECT_EQ(refusal_of(source), "no error");
  EXPECT_EQ(refusal_of(images), "no error");
  EXPECT_EQ(
      refusal_of(source + images + "[capture]\nleft_channel = \"L\"\nright_channel = \"R\"\n"),
      "no error");
}

TEST(OptionTable, has_each_key_once_with_its_default_in_range_and_its_sections_together) {
  std::set<std::string_view> keys;
  std::set<std::string_view> sections;
  std::string_view section;
  for (const Option& option : options()) {
    EXPECT_TRUE(keys.insert(option.key).second) << option.key;
    EXPECT_FALSE(option.help.empty()) << option.key;
    if (option.section() != section) {
      section = option.section();
      EXPECT_TRUE(sections.insert(section).second) << "scattered: " << section;
    }
  }
}

// Counts the members of an aggregate: the longest list of anythings that initialises it.
struct Anything {
  template <typename T>
  operator T() const;  // never defined: only asked whether it would convert
};
template <typename T, std::size_t... I>
constexpr bool takes(std::index_sequence<I...>) {
  return requires { T{(static_cast<void>(I), Anything{})...}; };
}
template <typename T, std::size_t N = 0>
constexpr std::size_t members() {
  if constexpr (takes<T>(std::make_index_sequence<N + 1>())) {
    return members<T, N + 1>();
  } else {
    return N;
  }
}

TEST(OptionTable, has_a_row_for_every_member_of_every_struct) {
  constexpr std::size_t kNestedStructs = 6;  // in EgomotionConfig
  constexpr std::size_t kMembers =
      members<DaemonConfig>() + members<CaptureConfig>() + members<FeaturesConfig>() +
      members<EgomotionConfig>() - kNestedStructs + members<RansacConfig>() +
      members<GaussNewtonConfig>() + members<SigmaPointFilterConfig>() + members<TrackMapConfig>() +
      members<RivalConfig>() + members<WheelsConfig>() + members<MovingObjectsConfig>() +
      members<PublishConfig>() + members<PipelineConfig>() + members<LoggingConfig>();
  EXPECT_EQ(options().size(), kMembers);
  EXPECT_EQ(members<Config>(), 8U);
}

TEST(Preset, thesis_is_the_published_method) {
  Config config;
  apply_file(config, EGOMOD_CONFIG_DIR "/thesis.toml");
  EXPECT_EQ(config.capture.max_rate_hz, 1.0);
  EXPECT_EQ(config.egomotion.method, EgomotionMethod::kSigmaPointKalmanFilter);
  EXPECT_EQ(config.moving_objects.method, MovingObjectsMethod::kThesis);
  EXPECT_EQ(config.moving_objects.threshold_mps, 0.2385);
  EXPECT_EQ(config.egomotion.ransac.threshold_px, 2.0);
  EXPECT_FALSE(config.egomotion.wheels.enable);
  EXPECT_NO_THROW(check(config));
}

// Other defaults must leave the preset as it is.
TEST(Preset, thesis_sets_whatever_its_method_depends_on) {
  Config defaults;
  apply_file(defaults, EGOMOD_CONFIG_DIR "/thesis.toml");
  Config config;
  config.egomotion.min_inliers = 99;
  config.egomotion.min_inlier_share = 0.99;
  config.egomotion.ransac = {.max_samples = 1, .threshold_px = 9.0, .confidence = 0.1};
  config.egomotion.sigma_point_filter = {.max_iterations = 1,
                                         .step_tolerance = 0.9,
                                         .initial_speed_sigma_mps = 0.9,
                                         .initial_turn_sigma_radps = 0.9,
                                         .acceleration_sigma_mps2 = 0.9,
                                         .turn_acceleration_sigma_radps2 = 0.9};
  MovingObjectsConfig& objects = config.moving_objects;
  objects.threshold_mps = objects.sigma_static_mps = objects.sigma_moving_mps = 9.0;
  objects.prior_moving = objects.decision_probability = 0.9;
  objects.velocity_bin_mps = objects.group_distance_m = 9.0;
  objects.velocity_bin_reach = objects.group_min_points = 9;
  apply_file(config, EGOMOD_CONFIG_DIR "/thesis.toml");
  EXPECT_EQ(dump(config), dump(defaults));
}

TEST(Preset, a_path_is_taken_as_it_is_and_an_unknown_name_lists_what_there_is) {
  EXPECT_EQ(find_preset("/etc/mine.toml"), "/etc/mine.toml");
  try {
    (void)find_preset("thesys");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("there are:"));
  }
}

}  // namespace
}  // namespace egomod
