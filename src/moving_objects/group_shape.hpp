// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "egomod/core/calibration.hpp"
#include "egomod/core/moving_objects.hpp"
#include "moving_objects/grouping.hpp"
#include "moving_objects/point_sample.hpp"

namespace egomod {

using Members = std::span<const Grouper::Index>;  // into a vector of PointSample

// The rectangle of the extreme coordinates (thesis, section IV-C).
[[nodiscard]] PixelRect rectangle_of(std::span<const PointSample> points, Members members);
// The one member that is beside all the others by more than they are wide and `least_px`, by its
// place in `members`; their number where there is none.
[[nodiscard]] std::size_t stray_of(std::span<const PointSample> points, Members members,
                                   double least_px);
[[nodiscard]] Eigen::Vector3d mean_position(std::span<const PointSample> points, Members members);
[[nodiscard]] Eigen::Vector3d mean_velocity(std::span<const PointSample> points, Members members);
[[nodiscard]] Eigen::Vector3d centre_of(std::span<const PointSample> points, Members members);
[[nodiscard]] Eigen::Vector3d extent_of(std::span<const PointSample> points, Members members);

// The rectangle of something that went from one position to another without turning, inside the
// image; where it is out of view, empty: u_max_px < u_min_px.
[[nodiscard]] PixelRect carried(const StereoCamera& camera, const PixelRect& rectangle,
                                const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m);

// `now`, with that share of how far `before` reaches beyond it; an empty `before` does not.
[[nodiscard]] PixelRect shrunk(const PixelRect& before, const PixelRect& now, double kept);

[[nodiscard]] float intersection_px2(const PixelRect& a, const PixelRect& b);
// What lies between the two along each axis where they do not overlap, and is common to both where
// they do; empty if they overlap along both.
[[nodiscard]] PixelRect gap_between(const PixelRect& a, const PixelRect& b);
[[nodiscard]] bool contains(const PixelRect& rectangle, const Eigen::Vector2d& pixel_px);

// Variance of a mean of K values whose errors correlate by rho: sigma^2 * this.
[[nodiscard]] double mean_variance_factor(std::size_t count, double correlation);

// Covariance of the mean of one of the points' vectors, of which `own` is their covariance, when
// their errors correlate.
[[nodiscard]] Eigen::Matrix3d mean_covariance(std::span<const PointSample> points, Members members,
                                              double correlation,
                                              Eigen::Matrix3d PointSample::*own);
// Fills speed and its standard error from velocity and covariance.
void set_speed(MovingObject& object);

}  // namespace egomod
