// SPDX-License-Identifier: Apache-2.0
#include "capture/log_index.hpp"

#include <algorithm>
#include <chrono>
#include <span>
#include <string>
#include <utility>

#include "capture/channels.hpp"
#include "capture/image_decoder.hpp"
#include "capture/pairing.hpp"
#include "capture/wheel_track.hpp"
#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

using Images = std::vector<LogImage>;

struct SegmentReading {
  WheelReading reading;
  int segment = 0;  // as of images
};

class Indexer {
 public:
  Indexer(LogFile& log, const CaptureConfig& config) : log_(log), channels_(config) {}

  void add(const LogEvent& event) {
    if (event.channel == kCalibrationChannel) {
      add_calibration(event);
    } else if (event.channel == kOdometryChannel) {
      add_odometry(event);
    } else if (event.channel == channels_.both || event.channel == channels_.left ||
               event.channel == channels_.right) {
      add_images(event);
    }
  }

  Images left;
  Images right;
  std::vector<SegmentReading> odometry;
  std::vector<TimedCalibration> calibrations;
  std::uint64_t untimed_messages = 0;

 private:
  [[noreturn]] void fail(const LogEvent& event, const std::string& what) const {
    throw SourceError(log_.path() + ": event " + std::to_string(event.number) + " on channel " +
                      event.channel + ": " + what);
  }

  void add_calibration(const LogEvent& event) {
    std::vector<std::uint8_t> bytes(event.data_bytes);
    const bool is_read = log_.read(event.data_offset, bytes);
    const auto calibration = is_read ? decode_calibration(bytes) : std::nullopt;
    if (!calibration) fail(event, "is not an egomod.calibration_t; name a rig file with --rig");
    calibrations.push_back(*calibration);
  }

  // Only a prior: what is none is left out.
  void add_odometry(const LogEvent& event) {
    std::vector<std::uint8_t> bytes(event.data_bytes);
    if (!log_.read(event.data_offset, bytes)) return;
    if (const auto reading = decode_odometry(bytes)) odometry.push_back({*reading, segment_});
  }

  void add_images(const LogEvent& event) {
    LogMessageReader reader(log_, event);
    const bool is_both = event.channel == channels_.both;
    StereoRecord found;
    ImageRecord one;
    const MessageState state = is_both ? find_images(reader, found) : find_image(reader, one);
    if (state == MessageState::kWrongType) {
      fail(event, is_both ? "is not a bot_core.images_t" : "is not a bot_core.image_t");
    }
    if (state == MessageState::kAmbiguous) fail(event, kAmbiguousImages);
    if (state == MessageState::kDamaged) {
      add_damaged(event, reader);
      return;
    }
    if (!is_both) (event.channel == channels_.left ? found.left : found.right) = one;
    if (found.left) add_image(event, *found.left, left);
    if (found.right) add_image(event, *found.right, right);
  }

  // It keeps its place among the pairs, so that the later ones keep their numbers. A time that does
  // not fit its neighbours' is damaged as well.
  void add_damaged(const LogEvent& event, MessageReader& reader) {
    LogImage image{.segment = segment_, .is_damaged = true};
    const auto utime_us = find_utime_us(reader);
    image.record.utime_us = utime_us.value_or(0);
    const bool fits =
        utime_us &&
        (!newest_ || std::chrono::abs(image.record.exposure() - *newest_) <= kReorderingWindow);
    if (!fits) {
      ++untimed_messages;
      return;
    }
    if (event.channel != channels_.right) left.push_back(image);
    if (event.channel != channels_.left) right.push_back(image);
  }

  void add_image(const LogEvent& event, const ImageRecord& record, Images& images) {
    if (!is_supported(record.pixel_format)) {
      fail(event, "pixel format " + std::to_string(record.pixel_format) +
                      " is not supported; GRAY, RGB, BGR, BAYER_GRBG, BAYER_RGGB and MJPEG are");
    }
    const Nanoseconds exposure = record.exposure();
    if (newest_ && exposure < *newest_ - kReorderingWindow) {
      ++segment_;
      newest_ = exposure;
    }
    newest_ = newest_ ? std::max(*newest_, exposure) : exposure;
    images.push_back({.record = record, .segment = segment_});
    images.back().record.data_offset += event.data_offset;
  }

  LogFile& log_;
  ImageChannels channels_;
  std::optional<Nanoseconds> newest_;
  int segment_ = 0;
};

// Into order of exposure; of several of one time the first stays.
void sort_by_exposure(Images& images) {
  const auto key = [](const LogImage& image) {
    return std::pair(image.segment, image.record.utime_us);
  };
  std::stable_sort(images.begin(), images.end(),
                   [&](const LogImage& a, const LogImage& b) { return key(a) < key(b); });
  const auto last =
      std::unique(images.begin(), images.end(),
                  [&](const LogImage& a, const LogImage& b) { return key(a) == key(b); });
  images.erase(last, images.end());
}

Images take_segment(const Images& images, int segment) {
  Images taken;
  std::copy_if(images.begin(), images.end(), std::back_inserter(taken),
               [&](const LogImage& image) { return image.segment == segment; });
  return taken;
}

std::vector<Nanoseconds> exposures(const Images& images) {
  std::vector<Nanoseconds> times;
  times.reserve(images.size());
  for (const LogImage& image : images) times.push_back(image.record.exposure());
  return times;
}

void append_pairs(const Images& left, const Images& right, double max_skew_s,
                  std::vector<LogPair>& pairs) {
  const auto left_times = exposures(left);
  const auto right_times = exposures(right);
  const Nanoseconds limit = skew_limit(max_skew_s, left_times, right_times);
  const auto partners = pair_by_exposure(left_times, right_times, limit);
  for (std::size_t i = 0; i < left.size(); ++i) {
    LogPair pair;
    pair.left = left[i];
    if (partners[i].nearest) pair.right = right[*partners[i].nearest];
    pair.is_accepted = partners[i].accepted;
    pair.discontinuity = i == 0 && left[i].segment > 0;
    pairs.push_back(pair);
  }
}

void add_wheels(std::span<const SegmentReading> odometry, int segment, double max_age_s,
                std::span<LogPair> pairs) {
  std::vector<WheelReading> readings;
  for (const SegmentReading& of : odometry) {
    if (of.segment == segment) readings.push_back(of.reading);
  }
  std::vector<Nanoseconds> times;
  for (const LogPair& pair : pairs) times.push_back(pair.left.record.exposure());
  const auto poses = wheel_poses(readings, times, max_age_s);
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].wheels = poses[i];
}

}  // namespace

LogIndex index_log(LogFile& log, const CaptureConfig& config) {
  Indexer indexer(log, config);
  while (const auto event = log.next_event()) indexer.add(*event);
  sort_by_exposure(indexer.left);
  sort_by_exposure(indexer.right);
  LogIndex index;
  index.calibrations = std::move(indexer.calibrations);
  index.untimed_messages = indexer.untimed_messages;
  const int segments = indexer.left.empty() ? 0 : indexer.left.back().segment + 1;
  for (int segment = 0; segment < segments; ++segment) {
    const std::size_t first = index.pairs.size();
    append_pairs(take_segment(indexer.left, segment), take_segment(indexer.right, segment),
                 config.max_skew_s, index.pairs);
    add_wheels(indexer.odometry, segment, config.wheels_max_age_s,
               std::span(index.pairs).subspan(first));
  }
  return index;
}

}  // namespace egomod
