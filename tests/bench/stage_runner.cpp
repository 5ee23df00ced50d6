// SPDX-License-Identifier: Apache-2.0
#include "stage_runner.hpp"

#include <algorithm>
#include <bot_core/image_t.hpp>
#include <span>
#include <stdexcept>

#include "capture/image_decoder.hpp"
#include "capture/image_message.hpp"
#include "capture/pair_preparer.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomod/features/feature_tracker.hpp"
#include "egomod/moving_objects/moving_object_detector.hpp"
#include "egomod/publish/publisher.hpp"
#include "yardstick.hpp"

namespace egomod::bench {
namespace {

constexpr std::size_t kWarmUpPairs = 3;

RawCamera raw_camera(const StereoCamera& camera) {
  RawCamera raw{.width_px = camera.width_px, .height_px = camera.height_px};
  raw.K << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1;
  raw.distortion = {-0.05, 0.01, 1e-4, 1e-4, 0.0};
  return raw;
}

Calibration raw_calibration(const StereoCamera& camera) {
  Calibration calibration;
  calibration.camera = camera;
  calibration.images_are_raw = true;
  calibration.left = calibration.right = raw_camera(camera);
  calibration.t_right_left_m = {-camera.baseline_m, 0.0, 0.0};
  return calibration;
}

}  // namespace

// Capture's work on a pair, once its images are there: to grey, and rectified.
class StageRunner::Mosaics {
 public:
  explicit Mosaics(const StereoCamera& camera) : preparer_(raw_calibration(camera)) {}

  void capture(const StereoPair& as_taken, StereoPair& pair) {
    preparer_.begin(pair);
    decode(as_taken.left, preparer_.left_target(pair));
    decode(as_taken.right, preparer_.right_target(pair));
    preparer_.finish(pair);
  }

 private:
  void decode(const Image& image, Image& to) {
    const auto bytes = static_cast<std::size_t>(image.stride_bytes()) *
                       static_cast<std::size_t>(image.height_px());
    const ImageRecord record{.width_px = image.width_px(),
                             .height_px = image.height_px(),
                             .row_stride_bytes = static_cast<std::int32_t>(image.stride_bytes()),
                             .pixel_format = bot_core::image_t::PIXEL_FORMAT_BAYER_GRBG,
                             .size_bytes = static_cast<std::int32_t>(bytes)};
    if (!decoder_.decode(record, std::span(image.row(0), bytes), preparer_.left_size(), to)) {
      throw std::runtime_error("a pair cannot be decoded");
    }
  }

  PairPreparer preparer_;
  ImageDecoder decoder_;
};

// What lives for a pass. Each stage reads from `in` and writes into `out`.
struct StageRunner::Stages {
  explicit Stages(const StageRunner& runner)
      : mosaics(*runner.mosaics_),
        tracker({.max_tracks = runner.max_tracks_}),
        estimator(EgomotionConfig{}),
        detector(MovingObjectsConfig{}),
        publisher({.tracks = true}, {.lcm_url = "file:///dev/null?mode=w"}) {}

  void run(Stage stage, const Frame& in, Frame& out) {
    switch (stage) {
      case Stage::kCapture:
        return mosaics.capture(in.pair, out.pair);
      case Stage::kFeatures:
        return tracker.track(in.pair, out.tracks);
      case Stage::kEgomotion:
        return estimator.estimate(in.tracks, out.motion);
      case Stage::kMovingObjects:
        return detector.detect(in.tracks, in.motion, out.objects);
      case Stage::kPublish:
        return publisher.publish(in);
    }
  }

  Mosaics& mosaics;
  FeatureTracker tracker;
  EgomotionEstimator estimator;
  MovingObjectDetector detector;
  Publisher publisher;
};

StageRunner::StageRunner(std::vector<StereoPair> pairs)
    : StageRunner(std::move(pairs), max_tracks({})) {}

StageRunner::StageRunner(std::vector<StereoPair> pairs, int max_tracks)
    : max_tracks_(max_tracks), frames_(pairs.size()) {
  if (pairs.size() <= kWarmUpPairs) throw std::runtime_error("the sequence is too short");
  for (std::size_t i = 0; i < pairs.size(); ++i) frames_[i].pair = std::move(pairs[i]);
  mosaics_ = std::make_unique<Mosaics>(first().calibration.camera);
  (void)pass_of_all();
}

StageRunner::~StageRunner() = default;

double StageRunner::mean_tracks() const {
  double sum = 0.0;
  for (const Frame& frame : frames_) sum += static_cast<double>(frame.tracks.tracks.size());
  return sum / static_cast<double>(frames_.size());
}

std::vector<double> StageRunner::pass(Stage stage) {
  Stages stages(*this);
  Frame out;
  std::vector<double> times_s;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const double start_s = cpu_seconds();
    stages.run(stage, frames_[i], out);
    if (i >= kWarmUpPairs) times_s.push_back(cpu_seconds() - start_s);
  }
  return times_s;
}

std::vector<StageRunner::StageTimes> StageRunner::pass_of_all() {
  Stages stages(*this);
  Frame captured;  // dropped: the pair itself stays what later stages are given
  std::vector<StageTimes> times_s;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    StageTimes pair_s{};
    for (std::size_t stage = 0; stage < kStageCount; ++stage) {
      const bool is_capture = static_cast<Stage>(stage) == Stage::kCapture;
      const double start_s = cpu_seconds();
      stages.run(static_cast<Stage>(stage), frames_[i], is_capture ? captured : frames_[i]);
      pair_s[stage] = cpu_seconds() - start_s;
    }
    if (i >= kWarmUpPairs) times_s.push_back(pair_s);
  }
  return times_s;
}

}  // namespace egomod::bench
