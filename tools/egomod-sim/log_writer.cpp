// SPDX-License-Identifier: Apache-2.0
#include "log_writer.hpp"

#include <cmath>
#include <egomod/calibration_t.hpp>

#include "egomod/publish/messages.hpp"

namespace egomod::sim {

LogWriter::LogWriter(const std::string& log, const StereoCamera& camera)
    : encoder_(ImageEncoding::kRaw, 0), record_(log) {
  calibration_.camera = camera;
}

void LogWriter::write(double t_s, const Image& left, const Image& right) {
  images_.utime = std::llround(1e6 * t_s);
  images_.n_images = 0;
  images_.image_types.clear();
  images_.images.resize(2);
  add(left, bot_core::images_t::LEFT);
  add(right, bot_core::images_t::RIGHT);
  if (!is_calibrated_) write_calibration();
  record_.write({images_channel_, images_.utime, encode_message(images_, buffer_)});
}

void LogWriter::add(const Image& image, std::int16_t type) {
  const auto slot = static_cast<std::size_t>(images_.n_images++);
  encoder_.encode(image.view(), images_.utime, images_.images[slot]);
  images_.image_types.push_back(type);
}

void LogWriter::write_calibration() {
  calibration_t message{};
  fill_message(calibration_, false, message);
  message.utime = images_.utime;
  record_.write({calibration_channel_, message.utime, encode_message(message, buffer_)});
  is_calibrated_ = true;
}

}  // namespace egomod::sim
