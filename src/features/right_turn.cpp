// SPDX-License-Identifier: Apache-2.0
#include "right_turn.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace egomod {
namespace {

constexpr std::size_t kPointsAPair = 16;
constexpr std::size_t kPointsAtFirst =
    150;  // a pair, until the rows are known, and where they are off
constexpr double kSettled_s = 3.0;
constexpr std::size_t kPairsBetween = 8;    // then
constexpr double kSettledSigma_rad = 3e-4;  // of pitch: a third of a pixel or less
constexpr int kMaxSteps = 8;
constexpr float kMinNcc = 0.85F;
constexpr float kMinTexture = 0.02F;
constexpr float kRowFloor_px2 = 0.05F * 0.05F;
constexpr float kModelError = 2.3F * 2.3F;  // as for observations
// Of a knock, and of what else puts rows off: the right focal length, and the right camera's place
// below and before the left one, over the baseline.
constexpr double kPriorTurn_rad = 0.035;
constexpr double kPriorYaw_rad = 0.01;  // less, since little tells it
constexpr double kPriorRatio = 0.003;
// And of the right lens's distortion, radial and by its being off the axis (k1, p1 of D. Brown).
constexpr double kPriorLens = 0.005;
constexpr double kPriorShiftedLens = 0.001;
// The other half of the latter, p2, moves the rows alike.
constexpr double kLensLikeYaw_rad = 1e-3;  // at least
// Where rows are wrong, so are many matches, and corners tell least of all.
constexpr double kKnownYaw_rad = 1.5e-3;
constexpr double kYawOfShiftedLens = 3.0;                      // times p1 as it is found
constexpr std::array kScales{32.0, 16.0, 8.0, 4.0, 3.0, 3.0};  // standard deviations
constexpr double kFormalSigmas = 3.0;  // a point's errors last for some pairs
constexpr double kMemory_s = 10.0;
constexpr double kSureSigmas = 4.0;
// Real cameras were off by 0.4 mrad, 0.3 px, at most.
constexpr double kLeastTurn_rad = 1.5e-3;
constexpr double kToKeep = 0.5;  // of both
// Of rows that one turn explains, in the pairs that first tell it.
constexpr std::ptrdiff_t kLeastRows = 25;
constexpr double kLeastShare = 0.6;
constexpr double kFits2 = 16.0;
constexpr double kMostTurn_rad = 0.05;
constexpr double kStep_rad = 4e-4;  // a fifth of a pixel
constexpr double kFirstWait_s = 0.1;
constexpr double kLongerWait = 4.0;  // each time

RightTurn::Parameters row_jacobian(const StereoCamera& camera, const RightTurn::Row& row) {
  const double x = (row.right_px.x() - camera.cx_px) / camera.fx_px;
  const double y = (row.right_px.y() - camera.cy_px) / camera.fy_px;
  RightTurn::Parameters J;
  J << -camera.fy_px * (1 + y * y), camera.fy_px * x * y, camera.fy_px * x, camera.fy_px * y,
      row.disparity_px, row.disparity_px * y, camera.fy_px * y * (x * x + y * y),
      camera.fy_px * (x * x + 3 * y * y);
  return J;
}

RightTurn::Information prior() {
  constexpr double kTurn = 1 / (kPriorTurn_rad * kPriorTurn_rad);
  constexpr double kYaw = 1 / (kPriorYaw_rad * kPriorYaw_rad);
  constexpr double kRatio = 1 / (kPriorRatio * kPriorRatio);
  constexpr double kLens = 1 / (kPriorLens * kPriorLens);
  constexpr double kShifted = 1 / (kPriorShiftedLens * kPriorShiftedLens);
  RightTurn::Parameters diagonal;
  diagonal << kTurn, kYaw, kTurn, kRatio, kRatio, kRatio, kLens, kShifted;
  return diagonal.asDiagonal();
}

// In a smaller image, so that rows that are some pixels off are found.
bool align_coarsely(const StereoImages& images, PixelPosition pixel, int level, AffineWarp& warp) {
  const float scale = 1.0F / static_cast<float>(1 << level);
  const PixelPosition small{pixel.u_px >> level, pixel.v_px >> level};
  if (!holds_template(images.left.level(level), small)) return false;
  AffineTemplate patch;
  build_template(images.left.level(level), small.u_px, small.v_px, patch);
  const ImagePoint start{
      static_cast<float>(small.u_px) + scale * (warp.u_px - static_cast<float>(pixel.u_px)),
      static_cast<float>(small.v_px) + scale * (warp.v_px - static_cast<float>(pixel.v_px))};
  AffineWarp coarse = warp;
  coarse.u_px = start.u_px;
  coarse.v_px = start.v_px;
  if (align(images.right.level(level), patch, kMaxSteps, coarse).ncc < kMinNcc) return false;
  warp.u_px += (coarse.u_px - start.u_px) / scale;
  warp.v_px += (coarse.v_px - start.v_px) / scale;
  return true;
}

// The left patch in the right image, free to leave its row.
bool find_row(const StereoImages& images, const FollowedPoint& point, double expected_px,
              bool coarsely, RightTurn::Row& row) {
  const PixelPosition pixel = nearest_pixel(point.left);
  if (!holds_template(images.left.level(0), pixel)) return false;
  AffineTemplate patch;
  build_template(images.left.level(0), pixel.u_px, pixel.v_px, patch);
  if (patch.tensor[2] < kMinTexture) return false;
  const auto u_px = static_cast<float>(pixel.u_px);
  const auto v_px = static_cast<float>(pixel.v_px);
  const StereoMeasurement& s = point.stereo;
  const ImagePoint right = right_of(point.left, s);
  AffineWarp warp{.u_px = right.u_px + (1.0F - s.slope_u) * (u_px - point.left.u_px) -
                          s.slope_v * (v_px - point.left.v_px),
                  .v_px = v_px + static_cast<float>(expected_px),
                  .a = 1.0F - s.slope_u,
                  .b = -s.slope_v};
  if (coarsely) static_cast<void>(align_coarsely(images, pixel, 2, warp));
  if (coarsely && !align_coarsely(images, pixel, 1, warp)) return false;
  const AlignmentResult result = align(images.right.level(0), patch, kMaxSteps, warp);
  if (!result.converged || result.ncc < kMinNcc) return false;
  const float residual =
      2.0F * std::max(1.0F - result.ncc, 0.0F) / (patch_effective_samples() - 7.0F);
  row.lower_px = static_cast<double>(warp.v_px - v_px);
  row.variance_px2 =
      static_cast<double>(kRowFloor_px2 + kModelError * residual * patch.inverse_hessian[7]);
  return std::isfinite(row.lower_px) && std::isfinite(row.variance_px2);
}

// So much of a parameter as is not its noise.
double sure_part(double found, double sigma) {
  return std::sqrt(std::max(0.0, found * found - 4 * sigma * sigma));
}

}  // namespace

void RightTurn::forget() {
  information_.setZero();
  pull_.setZero();
  estimate_.setZero();
  sigma_.setConstant(kPriorTurn_rad);
  turn_rad_.setZero();
  yaw_sigma_rad_ = age_s_ = waited_s_ = to_wait_s_ = 0.0;
  pairs_ = 0;
  fitting_rows_ = 0;
  is_off_ = has_changed_ = false;
}

bool RightTurn::take_change() { return std::exchange(has_changed_, false); }

std::size_t RightTurn::points_to_ask() const {
  if (sigma_[0] > kSettledSigma_rad) return kPointsAtFirst;
  if (is_off_) return kPointsAtFirst;
  return age_s_ < kSettled_s || pairs_ % kPairsBetween == 0 ? kPointsAPair : 0;
}

void RightTurn::measure(const StereoCamera& camera, const StereoImages& images,
                        const TrackStore& store, double dt_s) {
  rows_.clear();
  ++pairs_;
  const std::vector<FollowedPoint>& points = store.points();
  const std::size_t asked = std::min({points_to_ask(), points.size(), rows_.capacity()});
  if (asked == 0) return;
  const bool coarsely = sigma_[0] > kSettledSigma_rad;
  for (std::size_t k = 0; k < asked; ++k) {
    const FollowedPoint& point = points[(next_ + k * points.size() / asked) % points.size()];
    if (!point.stereo.valid) continue;
    Row row;
    row.disparity_px = static_cast<double>(point.stereo.disparity_px);
    row.right_px = {static_cast<double>(point.left.u_px - point.stereo.disparity_px),
                    static_cast<double>(point.left.v_px)};
    const double expected_px = row_jacobian(camera, row).dot(estimate_);
    if (find_row(images, point, expected_px, coarsely, row)) rows_.push_back(row);
  }
  next_ = (next_ + 1) % points.size();
  learn(camera, rows_, dt_s);
}

void RightTurn::learn(const StereoCamera& camera, std::span<const Row> rows, double dt_s) {
  const double keep = std::exp(-dt_s / kMemory_s);
  information_ *= keep;
  pull_ *= keep;
  age_s_ += dt_s;
  fit(camera, rows);
  decide(dt_s);
}

// Robustly, from coarse to fine (weights of S. Geman and D. McClure, 1987).
void RightTurn::fit(const StereoCamera& camera, std::span<const Row> rows) {
  Information A;
  Parameters b;
  Parameters estimate = estimate_;
  for (const double scale : kScales) {
    A.setZero();
    b.setZero();
    for (const Row& row : rows) {
      const Parameters J = row_jacobian(camera, row);
      const double r = row.lower_px - J.dot(estimate);
      const double share = scale * scale / (scale * scale + r * r / row.variance_px2);
      const double weight = share * share / row.variance_px2;
      A += weight * J * J.transpose();
      b += weight * row.lower_px * J;
    }
    const Information all = information_ + A + prior();
    estimate = all.ldlt().solve(pull_ + b);
  }
  if (!estimate.allFinite() || estimate.head<3>().norm() > kMostTurn_rad) return;
  const auto fits = [&](const Row& row) {
    const double r = row.lower_px - row_jacobian(camera, row).dot(estimate);
    return r * r < kFits2 * row.variance_px2;
  };
  const auto fitting = std::count_if(rows.begin(), rows.end(), fits);
  const bool agree = static_cast<double>(fitting) > kLeastShare * static_cast<double>(rows.size());
  fitting_rows_ = agree ? fitting_rows_ + fitting : 0;
  information_ += A;
  pull_ += b;
  estimate_ = estimate;
  const Information covariance = (information_ + prior()).inverse();
  sigma_ = kFormalSigmas * covariance.diagonal().cwiseSqrt();
}

bool RightTurn::is_surely_off() const {
  const double asked = is_off_ ? kToKeep : 1.0;
  const auto sure = [&](int k) {
    return std::abs(estimate_[k]) > asked * std::max(kLeastTurn_rad, kSureSigmas * sigma_[k]);
  };
  return (is_off_ || fitting_rows_ >= kLeastRows) && (sure(0) || sure(2));
}

bool RightTurn::is_worth_a_step(const Eigen::Vector3d& turn_rad) const {
  const auto differs = [&](int k) {
    return std::abs(turn_rad[k] - turn_rad_[k]) > std::max(kStep_rad, sigma_[k] / kFormalSigmas);
  };
  return differs(0) || differs(1) || differs(2);
}

// A knock that turned the camera in pitch and roll has turned it in yaw by about as much: that is
// all that is known of yaw but for the corners' rows, which a lens off its axis moves alike.
void RightTurn::decide(double dt_s) {
  waited_s_ += dt_s;
  const bool was_off = is_off_;
  is_off_ = is_surely_off();
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  double yaw_sigma_rad = 0.0;
  if (is_off_) {
    const double knock2 = 0.5 * (estimate_[0] * estimate_[0] + estimate_[2] * estimate_[2]);
    const double lens = kYawOfShiftedLens * sure_part(estimate_[7], sigma_[7]);
    const double rows2 = sigma_[1] * sigma_[1] + kLensLikeYaw_rad * kLensLikeYaw_rad + lens * lens;
    const bool tells = sigma_[1] < kKnownYaw_rad;
    const double share = tells ? knock2 / (knock2 + rows2) : 0.0;
    turn_rad = {estimate_[0], share * estimate_[1], estimate_[2]};
    yaw_sigma_rad = std::sqrt(tells ? share * rows2 : knock2);
  }
  const bool late = waited_s_ >= to_wait_s_ && is_worth_a_step(turn_rad);
  if (is_off_ == was_off && !(is_off_ && late)) return;
  turn_rad_ = turn_rad;
  yaw_sigma_rad_ = yaw_sigma_rad;
  has_changed_ = true;
  to_wait_s_ = std::max(kFirstWait_s, kLongerWait * to_wait_s_);
  waited_s_ = 0.0;
  // Found along wrong rows, what was learnt is worth less than what comes now.
  information_.setZero();
  pull_.setZero();
}

}  // namespace egomod
