// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bot_core/images_t.hpp>
#include <chrono>
#include <egomod/calibration_t.hpp>
#include <egomod/pose_t.hpp>
#include <filesystem>
#include <map>
#include <stop_token>

#include "capture/folder_contents.hpp"
#include "commands.hpp"
#include "egomod/app/progress.hpp"
#include "egomod/capture/frame_source.hpp"
#include "egomod/publish/messages.hpp"
#include "log_reader.hpp"
#include "overlay.hpp"
#include "picture.hpp"
#include "text_output.hpp"

namespace egomod::log {
namespace {

namespace fs = std::filesystem;

// What the log says about each pair, by its time, which images share.
struct Estimates {
  std::map<std::int64_t, Calibration> calibrations;
  std::map<std::int64_t, object_list_t> objects;
  std::map<std::int64_t, track_list_t> tracks;
  std::map<std::int64_t, std::int64_t> sequences;

  [[nodiscard]] const Calibration& calibration_at(std::int64_t utime_us) const {
    const auto later = calibrations.upper_bound(utime_us);
    return later == calibrations.begin() ? later->second : std::prev(later)->second;
  }
};

Estimates read_estimates(LogReader& reader) {
  Estimates estimates;
  while (const lcm::LogEvent* event = reader.next()) {
    if (event->channel == "EGOMOD_CALIBRATION") {
      calibration_t message{};
      reader.decode(*event, message);
      estimates.calibrations[message.utime] = calibration_from(message);
    } else if (event->channel == "EGOMOD_OBJECTS") {
      object_list_t message{};
      reader.decode(*event, message);
      estimates.objects[message.utime] = std::move(message);
    } else if (event->channel == "EGOMOD_TRACKS") {
      track_list_t message{};
      reader.decode(*event, message);
      estimates.tracks[message.utime] = std::move(message);
    } else if (event->channel == "EGOMOD_POSE") {
      pose_t message{};
      reader.decode(*event, message);
      estimates.sequences[message.utime] = message.sequence;
    }
  }
  return estimates;
}

class Drawing {
 public:
  Drawing(const Estimates& estimates, fs::path folder)
      : estimates_(estimates),
        folder_(std::move(folder)),
        progress_("draw", "pictures", estimates.objects.size()) {}

  // A picture has the number of its pair.
  void add(const ImageView& image, std::int64_t utime_us, std::int64_t sequence) {
    cv::Mat picture = picture_of(image);
    const auto tracks = estimates_.tracks.find(utime_us);
    if (tracks != estimates_.tracks.end()) draw_tracks(tracks->second, picture);
    const auto objects = estimates_.objects.find(utime_us);
    if (objects != estimates_.objects.end()) {
      draw_objects(objects->second, estimates_.calibration_at(utime_us), picture);
    }
    write_png(folder_ / fmt::format("{:06}.png", sequence), picture);
    progress_.update(++drawn_);
  }

  void finish() { progress_.finish(drawn_); }

  [[nodiscard]] std::uint64_t drawn() const { return drawn_; }

 private:
  const Estimates& estimates_;
  fs::path folder_;
  Progress progress_;
  std::uint64_t drawn_ = 0;
};

// The pairs of the record must be among those of the folder, which may hold more.
void require_same_sequence(const std::string& log, const std::string& images,
                           const Estimates& estimates) {
  const FolderContents contents = read_folder(images, "");
  const auto refuse = [&](const std::string& why) {
    throw LogError(fmt::format("{}: is not a record of {}: {}; name its own sequence with --images",
                               log, images, why));
  };
  const StereoCamera& recorded = estimates.calibrations.begin()->second.camera;
  const StereoCamera& camera = contents.calibration.camera;
  if (recorded.width_px != camera.width_px || recorded.height_px != camera.height_px) {
    refuse(fmt::format("it is of images of {}x{} pixels, not {}x{}", recorded.width_px,
                       recorded.height_px, camera.width_px, camera.height_px));
  }
  const auto& exposures = contents.left.exposures;
  if (estimates.sequences.size() > exposures.size()) {
    refuse(fmt::format("it has {} pairs, the folder {}", estimates.sequences.size(),
                       exposures.size()));
  }
  for (const auto& [utime_us, sequence] : estimates.sequences) {
    if (std::ranges::binary_search(exposures, std::chrono::microseconds(utime_us))) continue;
    refuse(fmt::format("no left image has the time of its pair {}, {:.6f} s", sequence,
                       static_cast<double>(utime_us) * 1e-6));
  }
}

void draw_from_folder(const std::string& images, Drawing& drawing) {
  const auto source = open_source("folder:" + images, {}, "", "");
  StereoPair pair;
  SourceState state = SourceState::kPair;
  while ((state = source->next(pair, std::stop_token())) == SourceState::kPair) {
    if (pair.left.empty()) continue;
    drawing.add(pair.left.view(), pair.utime_us(), static_cast<std::int64_t>(pair.sequence));
  }
  if (state == SourceState::kFailed) throw SourceError(source->error());
}

const bot_core::image_t* left_of(const bot_core::images_t& images) {
  for (std::size_t i = 0; i < images.images.size(); ++i) {
    if (images.image_types[i] == bot_core::images_t::LEFT) return &images.images[i];
  }
  return nullptr;
}

void decode(PictureDecoder& decoder, const bot_core::image_t& message, const std::string& log,
            Image& image) {
  try {
    decoder.decode(message, image);
  } catch (const std::runtime_error& error) {
    throw LogError(log + ": " + error.what());
  }
}

void draw_from_log(const std::string& log, const Estimates& estimates, Drawing& drawing) {
  LogReader reader(log);
  PictureDecoder decoder;
  bot_core::images_t images{};
  Image image;
  std::int64_t sequence = -1;
  while (const lcm::LogEvent* event = reader.next()) {
    if (event->channel != "EGOMOD_IMAGES") continue;
    reader.decode(*event, images);
    if (estimates.calibration_at(images.utime).images_are_raw) {
      throw LogError(log +
                     ": its images are raw, and estimates hold for rectified ones; give the " +
                     "sequence with --images");
    }
    const auto pose = estimates.sequences.find(images.utime);
    sequence = pose != estimates.sequences.end() ? pose->second : sequence + 1;
    if (const bot_core::image_t* left = left_of(images)) {
      decode(decoder, *left, log, image);
      drawing.add(image.view(), images.utime, sequence);
    }
  }
}

}  // namespace

void draw_log(const std::string& log, const std::string& folder, const std::string& images) {
  LogReader reader(log);
  const Estimates estimates = read_estimates(reader);
  if (estimates.calibrations.empty()) {
    reader.require_whole();
    throw LogError(log + ": holds no EGOMOD_CALIBRATION");
  }
  if (!images.empty()) require_same_sequence(log, images, estimates);
  make_folder(folder);
  Drawing drawing(estimates, folder);
  if (images.empty()) {
    draw_from_log(log, estimates, drawing);
  } else {
    draw_from_folder(images, drawing);
  }
  drawing.finish();
  if (drawing.drawn() == 0) {
    reader.require_whole();
    throw LogError(log + ": holds no EGOMOD_IMAGES; name the folder of the sequence with --images");
  }
  reader.require_whole();
}

}  // namespace egomod::log
