// SPDX-License-Identifier: Apache-2.0
#include "egomod/moving_objects/moving_object_detector.hpp"

#include <variant>

#include "moving_objects/filter_method.hpp"
#include "moving_objects/lag_method.hpp"
#include "moving_objects/thesis_method.hpp"

namespace egomod {

class MovingObjectDetector::Implementation {
 public:
  explicit Implementation(const MovingObjectsConfig& config) {
    if (config.method == MovingObjectsMethod::kThesis) {
      method_.emplace<ThesisMethod>(config);
    } else if (config.method == MovingObjectsMethod::kLag) {
      method_.emplace<LagMethod>(config);
    } else {
      method_.emplace<FilterMethod>(config);
    }
  }
  void detect(const TrackSet& tracks, const Egomotion& motion, MovingObjects& objects) {
    if (auto* thesis = std::get_if<ThesisMethod>(&method_)) thesis->detect(tracks, motion, objects);
    if (auto* lag = std::get_if<LagMethod>(&method_)) lag->detect(tracks, motion, objects);
    if (auto* filter = std::get_if<FilterMethod>(&method_)) filter->detect(tracks, motion, objects);
  }

 private:
  std::variant<std::monostate, ThesisMethod, LagMethod, FilterMethod> method_;
};

MovingObjectDetector::MovingObjectDetector(const MovingObjectsConfig& config)
    : implementation_(std::make_unique<Implementation>(config)) {}

MovingObjectDetector::~MovingObjectDetector() = default;

void MovingObjectDetector::detect(const TrackSet& tracks, const Egomotion& motion,
                                  MovingObjects& objects) {
  implementation_->detect(tracks, motion, objects);
}

}  // namespace egomod
