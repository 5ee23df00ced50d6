// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <egomod/object_list_t.hpp>
#include <egomod/track_list_t.hpp>
#include <opencv2/core/mat.hpp>

#include "egomod/core/calibration.hpp"
#include "egomod/core/image.hpp"

namespace egomod::log {

// The image in BGR.
[[nodiscard]] cv::Mat picture_of(const ImageView& image);
// Green: static, or an inlier of the motion; red: moving; orange: an outlier; blue: cannot be told.
void draw_tracks(const track_list_t& tracks, cv::Mat& picture);
// A rectangle with id and speed, and an arrow to where the object will be in half a second.
void draw_objects(const object_list_t& objects, const Calibration& calibration, cv::Mat& picture);

}  // namespace egomod::log
