// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bot_core/images_t.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/image.hpp"
#include "egomod/publish/image_encoder.hpp"
#include "egomod/publish/record_writer.hpp"

namespace egomod::sim {

// An LCM log of EGOMOD_CALIBRATION and EGOMOD_IMAGES, as the daemon's sources read it. Throws
// RecordError. Threads: one caller.
class LogWriter {
 public:
  LogWriter(const std::string& log, const StereoCamera& camera);
  void write(double t_s, const Image& left, const Image& right);
  void finish() { record_.flush(); }

 private:
  void add(const Image& image, std::int16_t type);
  void write_calibration();

  const std::string calibration_channel_ = "EGOMOD_CALIBRATION";
  const std::string images_channel_ = "EGOMOD_IMAGES";
  Calibration calibration_;
  ImageEncoder encoder_;
  RecordWriter record_;
  bot_core::images_t images_{};
  std::vector<std::uint8_t> buffer_;
  bool is_calibrated_ = false;
};

}  // namespace egomod::sim
