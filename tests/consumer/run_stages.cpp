// SPDX-License-Identifier: Apache-2.0
// The stages without the daemon, on two pairs of a picture that moves: no threads, no LCM.
#include <cstdio>
#include <egomod/core/frame.hpp>
#include <egomod/egomotion/egomotion_estimator.hpp>
#include <egomod/features/feature_tracker.hpp>
#include <egomod/moving_objects/moving_object_detector.hpp>

namespace {

constexpr int kWidth_px = 320;
constexpr int kHeight_px = 240;
constexpr int kDisparity_px = 20;

// Blocks of different grey, shifted.
void paint(egomod::Image& image, int shift_px) {
  image.resize(kWidth_px, kHeight_px);
  for (int v = 0; v < kHeight_px; ++v) {
    for (int u = 0; u < kWidth_px; ++u) {
      const unsigned block = static_cast<unsigned>((u + shift_px) / 12 * 7919 + v / 12 * 104729);
      image.row(v)[u] = static_cast<std::uint8_t>(block * 2654435761U >> 24U);
    }
  }
}

}  // namespace

int main() {
  egomod::FeatureTracker tracker{egomod::FeaturesConfig{}};
  egomod::EgomotionEstimator estimator{egomod::EgomotionConfig{}};
  egomod::MovingObjectDetector detector{egomod::MovingObjectsConfig{}};
  egomod::Frame frame;
  frame.pair.calibration.camera = {.fx_px = 260.0,
                                   .fy_px = 260.0,
                                   .cx_px = 159.5,
                                   .cy_px = 119.5,
                                   .baseline_m = 0.2,
                                   .width_px = kWidth_px,
                                   .height_px = kHeight_px};
  for (int i = 0; i < 2; ++i) {
    frame.pair.sequence = static_cast<std::uint64_t>(i);
    frame.pair.exposure = frame.pair.right_exposure = i * std::chrono::milliseconds(100);
    paint(frame.pair.left, 500 + i);
    paint(frame.pair.right, 500 + i + kDisparity_px);
    tracker.track(frame.pair, frame.tracks);
    estimator.estimate(frame.tracks, frame.motion);
    detector.detect(frame.tracks, frame.motion, frame.objects);
  }
  std::printf("%zu tracks, %d inliers\n", frame.tracks.tracks.size(), frame.motion.inliers);
  return frame.motion.inliers > 0 ? 0 : 1;
}
