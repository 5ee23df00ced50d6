// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "egomod/core/frame.hpp"

namespace egomod::bench {

// The pipeline's stages on pairs in memory, each to be timed alone, with the results of those
// before it as they come out with default configurations. Capture gets the images as Bayer mosaics
// of a camera with distortion; publish encodes all messages of a pair, tracks too, and writes them
// to where nothing is kept.
class StageRunner {
 public:
  explicit StageRunner(std::vector<StereoPair> pairs);
  StageRunner(std::vector<StereoPair> pairs, int max_tracks);
  StageRunner(const StageRunner&) = delete;
  StageRunner& operator=(const StageRunner&) = delete;
  ~StageRunner();

  [[nodiscard]] const StereoPair& first() const { return frames_.front().pair; }
  [[nodiscard]] std::size_t pairs() const { return frames_.size(); }
  [[nodiscard]] double mean_tracks() const;

  // CPU seconds for each pair of a pass that begins anew, without the first few: they fill buffers
  // and the map of tracks.
  [[nodiscard]] std::vector<double> pass(Stage stage);
  // The same with all stages after each other on each pair, as the pipeline does.
  using StageTimes = std::array<double, kStageCount>;
  [[nodiscard]] std::vector<StageTimes> pass_of_all();

 private:
  struct Stages;
  class Mosaics;

  int max_tracks_;
  std::vector<Frame> frames_;
  std::unique_ptr<Mosaics> mosaics_;
};

}  // namespace egomod::bench
