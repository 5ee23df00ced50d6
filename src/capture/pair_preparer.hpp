// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "capture/rectifier.hpp"
#include "egomod/core/calibration.hpp"
#include "egomod/core/stereo_pair.hpp"

namespace egomod {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;
  bool operator==(const ImageSize&) const = default;
};

// Why a source whose images are as `in_force` says cannot go on with `next`; empty if it can.
[[nodiscard]] std::string contradiction(const Calibration& in_force, const Calibration& next);

// The last step of every source: gives each pair its calibration, rectifies raw images, and lets
// the calibration change between two pairs.
// Threads: one calls begin, left_target, right_target and finish; any calls set_calibration.
class PairPreparer {
 public:
  // Throws SourceError on a calibration that cannot be right.
  explicit PairPreparer(const Calibration& calibration);

  // Takes effect at the next `begin`. Throws SourceError, and keeps the old one, if it cannot be
  // right or is for other image sizes.
  void set_calibration(const Calibration& calibration);

  // Starts a pair: empty images, calibration in force.
  void begin(StereoPair& pair);
  // Where the images of the pair are to be decoded into.
  [[nodiscard]] Image& left_target(StereoPair& pair);
  [[nodiscard]] Image& right_target(StereoPair& pair);
  // The sizes that the targets must have.
  [[nodiscard]] ImageSize left_size() const;
  [[nodiscard]] ImageSize right_size() const;
  // Both targets are filled: the pair leaves rectified.
  void finish(StereoPair& pair);
  // The pair cannot be used: it leaves without images.
  static void reject(StereoPair& pair, PairFault fault = PairFault::kDamaged);

 private:
  // A calibration and the tables that follow from it, made in the thread that brings it.
  struct Setup {
    explicit Setup(const Calibration& calibration);

    Calibration calibration;
    std::unique_ptr<const Rectifier> left;  // only for raw images
    std::unique_ptr<const Rectifier> right;
  };

  std::unique_ptr<const Setup> setup_;
  Image raw_left_;
  Image raw_right_;
  const Calibration first_;  // later ones must be for images of the same kind
  std::mutex pending_mutex_;
  std::unique_ptr<const Setup> pending_;
};

}  // namespace egomod
