// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "stereo_images.hpp"
#include "track_store.hpp"

namespace egomod {

// Learns by how much the right camera has turned since it was calibrated, from the rows at which
// it shows points: pitch moves all of them, roll those at the sides, yaw the corners. Disparities
// alone would not tell, since all of them fit a scene of another shape. Threads: one caller.
class RightTurn {
 public:
  using Parameters = Eigen::Matrix<double, 8, 1>;
  using Information = Eigen::Matrix<double, 8, 8>;

  // Where a point should be seen in the right image, and how many rows lower it is.
  struct Row {
    Eigen::Vector2d right_px;
    double disparity_px = 0.0;
    double lower_px = 0.0;
    double variance_px2 = 0.0;
  };

  explicit RightTurn(std::size_t capacity) { rows_.reserve(capacity); }

  void forget();
  // Of a pair whose images were exposed together, after its disparities were measured.
  void measure(const StereoCamera& camera, const StereoImages& images, const TrackStore& store,
               double dt_s);
  void learn(const StereoCamera& camera, std::span<const Row> rows, double dt_s);

  // What no good calibration is off by: pitch or roll. Yaw alone looks like a lens off its axis.
  [[nodiscard]] bool is_off() const { return is_off_; }
  // Rotation vector, x_seen = Exp(turn) x_calibrated in the right camera's axes. Zero unless
  // the camera is off; changed in few steps, since each of them ends all tracks.
  [[nodiscard]] const Eigen::Vector3d& turn_rad() const { return turn_rad_; }
  // Standard deviation of its yaw, which puts all disparities off alike; zero as well.
  [[nodiscard]] double yaw_sigma_rad() const { return yaw_sigma_rad_; }
  // Whether it has since this was asked last.
  [[nodiscard]] bool take_change();

 private:
  [[nodiscard]] std::size_t points_to_ask() const;
  void fit(const StereoCamera& camera, std::span<const Row> rows);
  [[nodiscard]] bool is_surely_off() const;
  [[nodiscard]] bool is_worth_a_step(const Eigen::Vector3d& turn_rad) const;
  void decide(double dt_s);

  std::vector<Row> rows_;
  std::size_t next_ = 0;  // the point that is asked first in the next pair
  Information information_ = Information::Zero();
  Parameters pull_ = Parameters::Zero();
  Parameters estimate_ = Parameters::Zero();
  Parameters sigma_ = Parameters::Zero();
  Eigen::Vector3d turn_rad_ = Eigen::Vector3d::Zero();
  double yaw_sigma_rad_ = 0.0;
  double age_s_ = 0.0;      // that was learnt from
  double waited_s_ = 0.0;   // since the last step...
  double to_wait_s_ = 0.0;  // ...and until the next
  std::size_t pairs_ = 0;
  std::ptrdiff_t fitting_rows_ = 0;  // of the last pairs, as long as most agree
  bool is_off_ = false;
  bool has_changed_ = false;
};

}  // namespace egomod
