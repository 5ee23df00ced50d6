// SPDX-License-Identifier: Apache-2.0
#include "capture/pair_preparer.hpp"

#include <string>
#include <utility>

#include "capture/calibration_check.hpp"
#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

ImageSize size_of_left(const Calibration& calibration) {
  if (calibration.images_are_raw) return {calibration.left.width_px, calibration.left.height_px};
  return {calibration.camera.width_px, calibration.camera.height_px};
}

ImageSize size_of_right(const Calibration& calibration) {
  if (calibration.images_are_raw) return {calibration.right.width_px, calibration.right.height_px};
  return {calibration.camera.width_px, calibration.camera.height_px};
}

}  // namespace

std::string contradiction(const Calibration& in_force, const Calibration& next) {
  if (next.images_are_raw != in_force.images_are_raw) {
    return std::string("images_are_raw says that images are ") +
           (in_force.images_are_raw ? "rectified, but this source's are raw"
                                    : "raw, but this source's are rectified");
  }
  if (size_of_left(next) != size_of_left(in_force) ||
      size_of_right(next) != size_of_right(in_force)) {
    return "is for images of another size than this source's";
  }
  return {};
}

PairPreparer::Setup::Setup(const Calibration& given) : calibration(given) {
  if (const std::string fault = fault_of(given); !fault.empty()) {
    throw SourceError("calibration: " + fault);
  }
  if (!given.images_are_raw) return;
  left = std::make_unique<Rectifier>(given.left, given.camera);
  right = std::make_unique<Rectifier>(given.right, given.camera);
}

PairPreparer::PairPreparer(const Calibration& calibration)
    : setup_(std::make_unique<Setup>(calibration)), first_(calibration) {}

ImageSize PairPreparer::left_size() const { return size_of_left(first_); }

ImageSize PairPreparer::right_size() const { return size_of_right(first_); }

void PairPreparer::set_calibration(const Calibration& calibration) {
  if (const std::string why = contradiction(first_, calibration); !why.empty()) {
    throw SourceError("calibration: " + why);
  }
  auto setup = std::make_unique<Setup>(calibration);
  const std::lock_guard lock(pending_mutex_);
  pending_ = std::move(setup);
}

void PairPreparer::begin(StereoPair& pair) {
  {
    const std::lock_guard lock(pending_mutex_);
    if (pending_) setup_ = std::move(pending_);
  }
  pair.calibration = setup_->calibration;
  pair.status = PairStatus::kOk;
  pair.fault = PairFault::kNone;
  pair.discontinuity = false;
  pair.epoch_offset = Nanoseconds(0);
  pair.wheels.reset();
  pair.left.resize(0, 0);
  pair.right.resize(0, 0);
}

Image& PairPreparer::left_target(StereoPair& pair) { return setup_->left ? raw_left_ : pair.left; }

Image& PairPreparer::right_target(StereoPair& pair) {
  return setup_->right ? raw_right_ : pair.right;
}

void PairPreparer::finish(StereoPair& pair) {
  if (!setup_->left) return;
  setup_->left->apply(raw_left_, pair.left);
  setup_->right->apply(raw_right_, pair.right);
}

void PairPreparer::reject(StereoPair& pair, PairFault fault) {
  pair.status = PairStatus::kRejected;
  pair.fault = fault;
  pair.left.resize(0, 0);
  pair.right.resize(0, 0);
}

}  // namespace egomod
