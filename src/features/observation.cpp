// SPDX-License-Identifier: Apache-2.0
#include "observation.hpp"

#include <algorithm>
#include <cmath>

namespace egomod {
namespace {

// Residual variance over texture ranks points well, but is too small: neighbouring residuals
// correlate, and the patch is never quite affine. The factor was chosen on rendered sequences
// against exact motion, where 2.3 to 3.5 in standard deviation fitted a track's whole life; it is
// a compromise, not a law: see FeatureTracker on what it means from pair to pair.
constexpr float kModelError = 2.3F * 2.3F;
constexpr float kLeftFloor_px2 = 0.04F * 0.04F;
constexpr float kDisparityFloor_px2 = 0.05F * 0.05F;
// The derivative filter passes this share of the grey values' noise variance, which feigns texture.
constexpr float kGradientNoise = 2.0F * (22.0F * 22.0F + 3.0F * 3.0F) / (32.0F * 32.0F);
constexpr float kMinEigenvalue = 2e-3F;

struct Symmetric2 {
  float uu, uv, vv;
};

// Of the normalised grey values: half of the residual's variance 2 (1 - NCC) belongs to each image.
float noise_variance(const FollowedPoint& point) {
  const float ncc = point.age == 0 ? point.stereo.ncc : point.ncc;
  return std::max(1.0F - ncc, 0.0F);
}

Symmetric2 tensor_without_noise(const FollowedPoint& point, const AffineTemplate& anchor) {
  const float noise = kGradientNoise * noise_variance(point);
  return {anchor.tensor[0] - noise, anchor.tensor[1], anchor.tensor[2] - noise};
}

float smaller_eigenvalue(const Symmetric2& t) {
  const float half = 0.5F * (t.uu - t.vv);
  return 0.5F * (t.uu + t.vv) - std::sqrt(half * half + t.uv * t.uv);
}

Symmetric2 inverse(const Symmetric2& t) {
  const float k = 1.0F / (t.uu * t.vv - t.uv * t.uv);
  return {t.vv * k, -t.uv * k, t.uu * k};
}

// A t A^T
Symmetric2 transformed(const AffineWarp& w, const Symmetric2& t) {
  const float au = w.a * t.uu + w.b * t.uv;
  const float av = w.a * t.uv + w.b * t.vv;
  const float cu = w.c * t.uu + w.d * t.uv;
  const float cv = w.c * t.uv + w.d * t.vv;
  return {au * w.a + av * w.b, au * w.c + av * w.d, cu * w.c + cv * w.d};
}

// sigma^2 / n * (structure tensor)^-1 of the template, taken to this image.
Symmetric2 left_covariance(const FollowedPoint& point, const AffineTemplate& anchor) {
  if (point.age == 0) return {0.0F, 0.0F, 0.0F};  // the anchor defines the point
  Symmetric2 tensor = tensor_without_noise(point, anchor);
  const float lift = std::max(kMinEigenvalue - smaller_eigenvalue(tensor), 0.0F);
  tensor.uu += lift;
  tensor.vv += lift;
  const float residual = 2.0F * noise_variance(point) / (patch_effective_samples() - 7.0F);
  const Symmetric2 shape = transformed(point.warp, inverse(tensor));
  const float scale = kModelError * residual;
  return {scale * shape.uu, scale * shape.uv, scale * shape.vv};
}

}  // namespace

float texture(const FollowedPoint& point, const AffineTemplate& anchor) {
  return std::max(smaller_eigenvalue(tensor_without_noise(point, anchor)), 0.0F);
}

StereoObservation observe(const FollowedPoint& point, const AffineTemplate& anchor) {
  Symmetric2 left = left_covariance(point, anchor);
  left.uu += kLeftFloor_px2;
  left.vv += kLeftFloor_px2;
  // The disparity is read off the plane at the measured left position, whose error it shares.
  const StereoMeasurement& s = point.stereo;
  const float ud = s.slope_u * left.uu + s.slope_v * left.uv;
  const float vd = s.slope_u * left.uv + s.slope_v * left.vv;
  const float own = kModelError * s.variance_px2 + kDisparityFloor_px2 + s.skew_variance_px2;
  const float dd = own + s.slope_u * ud + s.slope_v * vd;
  return {.u_px = point.left.u_px,
          .v_px = point.left.v_px,
          .disparity_px = s.disparity_px,
          .covariance_px2 = {left.uu, left.uv, ud, left.vv, vd, dd}};
}

}  // namespace egomod
