// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bot_core/images_t.hpp>
#include <cstdint>
#include <egomod/truth_object_list_t.hpp>
#include <egomod/truth_pose_t.hpp>
#include <map>
#include <string>
#include <vector>

#include "driven_base.hpp"
#include "egomod/core/image.hpp"
#include "egomod/publish/image_encoder.hpp"
#include "egomod/publish/record_writer.hpp"
#include "simulator.hpp"

namespace egomod::sim {

// An LCM log of EGOMOD_CALIBRATION, EGOMOD_IMAGES, SIM_TRUTH_POSE, SIM_TRUTH_OBJECTS and, of a
// driven rig, PIONEER_ODOMETRY, as the daemon's sources read it. An image that arrives late is
// logged late, and on its own. Throws RecordError. Threads: one caller.
class LogWriter {
 public:
  LogWriter(const std::string& log, const World& world);
  // Exposures come in order of time.
  void write_pair(const Exposure& exposure, const Image& left, const Image& right);
  void write_image(Eye eye, const Exposure& exposure, const Image& image);
  // Of the next left image, in their order.
  void write_truth(double t_s, const Truth& truth);
  // All that the base reports up to a time that it knows, at its own rate.
  void write_odometry(double until_s, const DrivenBase& base);
  void finish();

 private:
  struct Event {
    const std::string& channel;
    std::vector<std::uint8_t> bytes;
  };
  template <typename Message>
  void add(const std::string& channel, std::int64_t arrival_us, const Message& message);
  void add_image(const Image& image, std::int16_t type);
  void begin_images(std::int64_t utime);
  void write_calibration(std::int64_t utime);
  // What arrives before then can no longer be overtaken.
  void flush_until(std::int64_t utime);

  const std::string calibration_channel_ = "EGOMOD_CALIBRATION";
  const std::string images_channel_ = "EGOMOD_IMAGES";
  const std::string pose_channel_;
  const std::string objects_channel_;
  const std::string odometry_channel_;
  Calibration calibration_;
  ImageEncoder encoder_;
  RecordWriter record_;
  bot_core::images_t images_{};
  truth_pose_t pose_{};
  truth_object_list_t objects_{};
  std::int64_t left_images_ = 0;
  std::int64_t odometry_messages_ = 0;
  std::multimap<std::int64_t, Event> waiting_;  // by arrival
  bool is_calibrated_ = false;
};

}  // namespace egomod::sim
