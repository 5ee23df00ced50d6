// SPDX-License-Identifier: Apache-2.0
#include "overlay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "egomod/core/geometry.hpp"
#include "egomod/core/speed_units.hpp"

namespace egomod::log {
namespace {

constexpr double kArrow_s = 0.5;
constexpr double kNearest_m = 0.1;
constexpr double kLargestCoordinate_px = 1e4;  // beyond it OpenCV's fixed point overflows

const cv::Scalar kGreen(80, 200, 80);
const cv::Scalar kRed(60, 60, 255);
const cv::Scalar kOrange(40, 160, 255);
const cv::Scalar kBlue(255, 160, 60);
const cv::Scalar kGrey(170, 170, 170);
const cv::Scalar kYellow(60, 240, 255);

cv::Scalar colour(const track_t& track) {
  switch (track.state) {
    case track_t::STATE_STATIC:
      return kGreen;
    case track_t::STATE_MOVING:
      return kRed;
    case track_t::STATE_UNOBSERVABLE:
      return kBlue;
    default:
      break;
  }
  if (track.role == track_t::ROLE_INLIER) return kGreen;
  return track.role == track_t::ROLE_OUTLIER ? kOrange : kGrey;
}

cv::Scalar colour(const object_t& object) {
  switch (object.state) {
    case object_t::STATE_MOVING:
      return kRed;
    case object_t::STATE_COASTING:
      return kOrange;
    case object_t::STATE_STOPPED:
      return kBlue;
    default:
      return kGrey;
  }
}

cv::Point pixel(double u_px, double v_px) {
  const auto whole = [](double x) {
    return static_cast<int>(
        std::lround(std::clamp(x, -kLargestCoordinate_px, kLargestCoordinate_px)));
  };
  return {whole(u_px), whole(v_px)};
}

// Two lines above the rectangle's corner, within the picture. OpenCV's letters have no plus-minus
// sign.
void write_speed(const object_t& object, const cv::Point& top_left, cv::Mat& picture) {
  constexpr double kLetters = 0.45;
  constexpr int kLine_px = 15;
  const std::array<std::string, 2> lines{
      fmt::format("{}: {:.2f}+-{:.2f} m/s", object.id, object.speed, object.speed_sigma),
      fmt::format("{:.1f} km/h", kKmhPerMps * object.speed)};
  int width_px = 0;
  for (const std::string& line : lines)
    width_px = std::max(
        width_px, cv::getTextSize(line, cv::FONT_HERSHEY_SIMPLEX, kLetters, 1, nullptr).width);
  cv::Point at{std::max(0, std::min(top_left.x, picture.cols - width_px)),
               std::max(top_left.y - 5 - kLine_px, 12)};
  for (const std::string& line : lines) {
    cv::putText(picture, line, at, cv::FONT_HERSHEY_SIMPLEX, kLetters, colour(object), 1,
                cv::LINE_AA);
    at.y += kLine_px;
  }
}

void draw_arrow(const object_t& object, const Calibration& calibration, cv::Mat& picture) {
  const Eigen::Isometry3d T_camera_body = calibration.T_body_camera.inverse();
  const Eigen::Vector3d from = T_camera_body * Eigen::Vector3d::Map(object.body_pos);
  const Eigen::Vector3d to =
      from + kArrow_s * (T_camera_body.linear() * Eigen::Vector3d::Map(object.body_vel));
  if (from.z() < kNearest_m || to.z() < kNearest_m) return;
  const Eigen::Vector3d a = project(calibration.camera, from);
  const Eigen::Vector3d b = project(calibration.camera, to);
  cv::arrowedLine(picture, pixel(a.x(), a.y()), pixel(b.x(), b.y()), kYellow, 2, cv::LINE_AA, 0,
                  0.2);
}

}  // namespace

cv::Mat picture_of(const ImageView& image) {
  // OpenCV has no const view; cvtColor only reads.
  const cv::Mat grey(image.height_px, image.width_px, CV_8UC1,
                     const_cast<std::uint8_t*>(image.data),
                     static_cast<std::size_t>(image.stride_bytes));
  cv::Mat picture;
  cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
  return picture;
}

void draw_tracks(const track_list_t& tracks, cv::Mat& picture) {
  for (const track_t& track : tracks.tracks) {
    cv::circle(picture, pixel(track.u, track.v), 2, colour(track), cv::FILLED, cv::LINE_AA);
  }
}

void draw_objects(const object_list_t& objects, const Calibration& calibration, cv::Mat& picture) {
  for (const object_t& object : objects.objects) {
    const cv::Point top_left = pixel(object.u_min, object.v_min);
    cv::rectangle(picture, top_left, pixel(object.u_max, object.v_max), colour(object), 2);
    write_speed(object, top_left, picture);
    draw_arrow(object, calibration, picture);
  }
}

}  // namespace egomod::log
