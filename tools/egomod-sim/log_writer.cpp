// SPDX-License-Identifier: Apache-2.0
#include "log_writer.hpp"

#include <cmath>
#include <egomod/calibration_t.hpp>
#include <limits>

#include "base_link.hpp"
#include "egomod/publish/messages.hpp"
#include "truth_messages.hpp"

namespace egomod::sim {
namespace {

std::int64_t microseconds(double t_s) { return std::llround(1e6 * t_s); }

std::int64_t arrival_us(const Exposure& exposure) {
  return microseconds(exposure.t_s) + microseconds(exposure.late_s);
}

}  // namespace

LogWriter::LogWriter(const std::string& log, const World& world)
    : pose_channel_(kTruthPoseChannel),
      objects_channel_(kTruthObjectsChannel),
      odometry_channel_(kOdometryChannel),
      calibration_(written_calibration(world.camera, world.optics)),
      encoder_(ImageEncoding::kRaw, 0),
      record_(log) {}

template <typename Message>
void LogWriter::add(const std::string& channel, std::int64_t arrival_us, const Message& message) {
  Event event{channel, {}};
  (void)encode_message(message, event.bytes);
  waiting_.emplace(arrival_us, std::move(event));
}

void LogWriter::flush_until(std::int64_t utime) {
  while (!waiting_.empty() && waiting_.begin()->first < utime) {
    const auto& [arrival, event] = *waiting_.begin();
    record_.write({event.channel, arrival, event.bytes});
    waiting_.erase(waiting_.begin());
  }
}

void LogWriter::begin_images(std::int64_t utime) {
  flush_until(utime);
  if (!is_calibrated_) write_calibration(utime);
  images_.utime = utime;
  images_.n_images = 0;
  images_.image_types.clear();
}

void LogWriter::add_image(const Image& image, std::int16_t type) {
  const auto slot = static_cast<std::size_t>(images_.n_images++);
  images_.images.resize(slot + 1);
  encoder_.encode(image.view(), images_.utime, images_.images[slot]);
  images_.image_types.push_back(type);
}

void LogWriter::write_pair(const Exposure& exposure, const Image& left, const Image& right) {
  begin_images(microseconds(exposure.t_s));
  add_image(left, bot_core::images_t::LEFT);
  add_image(right, bot_core::images_t::RIGHT);
  add(images_channel_, arrival_us(exposure), images_);
}

void LogWriter::write_image(Eye eye, const Exposure& exposure, const Image& image) {
  begin_images(microseconds(exposure.t_s));
  add_image(image, eye == Eye::kLeft ? bot_core::images_t::LEFT : bot_core::images_t::RIGHT);
  add(images_channel_, arrival_us(exposure), images_);
}

void LogWriter::write_truth(double t_s, const Truth& truth) {
  const std::int64_t utime = microseconds(t_s);
  fill_message(truth, calibration_.T_body_camera, utime, left_images_, pose_);
  fill_message(truth, calibration_.T_body_camera, utime, left_images_, objects_);
  ++left_images_;
  add(pose_channel_, utime, pose_);
  add(objects_channel_, utime, objects_);
}

void LogWriter::write_odometry(double until_s, const DrivenBase& base) {
  for (;; ++odometry_messages_) {
    const double t_s = static_cast<double>(odometry_messages_) / base.drive().odometry_rate_hz;
    if (t_s > until_s) return;
    const odometry_t message = odometry(base.at(t_s), t_s, odometry_messages_);
    add(odometry_channel_, message.utime, message);
  }
}

void LogWriter::write_calibration(std::int64_t utime) {
  calibration_t message{};
  fill_message(calibration_, calibration_.images_are_raw, message);
  message.utime = utime;
  add(calibration_channel_, utime, message);
  is_calibrated_ = true;
}

void LogWriter::finish() {
  flush_until(std::numeric_limits<std::int64_t>::max());
  record_.flush();
}

}  // namespace egomod::sim
