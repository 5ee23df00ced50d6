// SPDX-License-Identifier: Apache-2.0
#include "recorder.hpp"

#include <chrono>
#include <optional>
#include <stdexcept>

#include "log_writer.hpp"

namespace egomod::sim {
namespace {

class Recorder {
 public:
  Recorder(Simulator& simulator, const Recording& recording) : simulator_(simulator) {
    const World& world = simulator.world();
    if (!recording.folder.empty()) folder_.emplace(recording.folder, world, recording.options);
    if (!recording.log.empty()) log_.emplace(recording.log, world);
  }

  void take_pair(const Exposure& exposure) {
    simulator_.take_pair(exposure.number, left_, right_);
    if (log_) log_->write_pair(exposure, left_, right_);
    take_truth(exposure);
    write_left(exposure);
    write_right(exposure);
  }

  void take_left(const Exposure& exposure) {
    simulator_.take_image(Eye::kLeft, exposure.number, left_);
    if (log_) log_->write_image(Eye::kLeft, exposure, left_);
    take_truth(exposure);
    write_left(exposure);
  }

  void take_right(const Exposure& exposure) {
    simulator_.take_image(Eye::kRight, exposure.number, right_);
    if (log_) log_->write_image(Eye::kRight, exposure, right_);
    write_right(exposure);
  }

  void finish() {
    if (folder_) folder_->finish();
    if (log_) log_->finish();
  }

 private:
  void take_truth(const Exposure& exposure) {
    simulator_.take_truth(exposure.number, truth_);
    if (!log_) return;
    log_->write_truth(exposure.t_s, truth_);
    if (simulator_.base() != nullptr) log_->write_odometry(exposure.t_s, *simulator_.base());
  }
  void write_left(const Exposure& exposure) {
    if (folder_) folder_->write_left(exposure.t_s, left_, truth_);
  }
  void write_right(const Exposure& exposure) {
    if (folder_) folder_->write_right(exposure.t_s, right_);
  }

  Simulator& simulator_;
  std::optional<FolderWriter> folder_;
  std::optional<LogWriter> log_;
  Image left_;
  Image right_;
  Truth truth_;
};

}  // namespace

RecordingSummary record(Simulator& simulator, const Recording& recording) {
  const World& world = simulator.world();
  const auto left = delivered(world, Eye::kLeft);
  const auto right = delivered(world, Eye::kRight);
  if (left.empty() || right.empty()) {
    throw std::runtime_error("a camera delivers no image within the world's duration");
  }
  Recorder recorder(simulator, recording);
  const auto begin = std::chrono::steady_clock::now();
  const bool pairs = world.timing.comes_in_pairs();
  auto next_right = right.begin();
  for (const Exposure& exposure : left) {
    if (pairs) {
      recorder.take_pair(exposure);
      continue;
    }
    while (next_right != right.end() && next_right->t_s < exposure.t_s) {
      recorder.take_right(*next_right++);
    }
    recorder.take_left(exposure);
  }
  while (!pairs && next_right != right.end()) recorder.take_right(*next_right++);
  recorder.finish();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  return {static_cast<int>(left.size()), static_cast<int>(right.size()), took.count()};
}

}  // namespace egomod::sim
