// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/noise_model.hpp"

#include <algorithm>
#include <cmath>

namespace egomod {
namespace {

// Of the chi-square law with 1 degree of freedom: its median, and how fast the share above it grows
// with the logarithm of a factor.
constexpr double kMedianChi2_1 = 0.4549;
constexpr double kShareSlope = 0.2143;
constexpr double kMemory_s = 4.0;
constexpr double kStartWeight = 50.0;    // a first pair does not settle it
constexpr double kShrinkWeight = 300.0;  // a bin of as many stands half way to the common factor
constexpr double kLeastWeight = 1.0;
constexpr double kMostStep = 1.0;
constexpr double kMostLogFactor = 4.0;
constexpr double kOldPairs = 10.0;
constexpr double kLeastTexture = 1e-6;
constexpr double kTextureGain = 2.0;  // of the share of richer tracks over a half

}  // namespace

void NoiseModel::Scale::add(double residual_px, double variance, double floor_px2) {
  const double expected_px2 = factor * variance + floor_px2;
  above += residual_px * residual_px > kMedianChi2_1 * expected_px2 ? 1 : 0;
  sum_px2 += variance;
  ++count;
}

// A Newton step on the share above the median, weighed by how much is new.
void NoiseModel::Scale::learn(double forget) {
  weight *= forget;
  if (count == 0) return;
  weight += count;
  const double share = static_cast<double>(above) / count;
  const double step = std::clamp((share - 0.5) / kShareSlope, -kMostStep, kMostStep);
  log_factor = std::clamp(log_factor + count / (weight + kStartWeight) * step, -kMostLogFactor,
                          kMostLogFactor);
  factor = std::exp(log_factor);
  variance_px2 += count / weight * (sum_px2 / count - variance_px2);
  forget_pair();
}

void NoiseModel::Scale::forget_pair() {
  sum_px2 = 0.0;
  above = count = 0;
}

std::size_t NoiseModel::bin_of(const NoiseKey& key) const {
  const auto depth = static_cast<std::size_t>(
      std::upper_bound(kDepthEdges_m.begin(), kDepthEdges_m.end(), key.depth_m) -
      kDepthEdges_m.begin());
  const bool is_rich = std::log(std::max(key.texture, kLeastTexture)) > log_texture_;
  const bool is_old = key.age_pairs >= kOldPairs;
  return 4 * depth + (is_rich ? 2U : 0U) + (is_old ? 1U : 0U);
}

double NoiseModel::shrunk(const Scale& own, const Scale& common) const {
  const double trust = own.weight / (own.weight + kShrinkWeight);
  return std::exp(common.log_factor + trust * (own.log_factor - common.log_factor));
}

NoiseModel::Factors NoiseModel::factors(const NoiseKey& key) const {
  const Bin& bin = bins_[bin_of(key)];
  return {shrunk(bin.pixel, common_.pixel), shrunk(bin.disparity, common_.disparity)};
}

void NoiseModel::add(const NoiseKey& key, const NoiseResidual& r) {
  for (Bin* const bin : {&bins_[bin_of(key)], &common_}) {
    bin->pixel.add(r.u_px, r.variance_u_px2, floor_px2_);
    bin->pixel.add(r.v_px, r.variance_v_px2, floor_px2_);
    bin->disparity.add(r.disparity_px, r.variance_disparity_px2, floor_px2_);
  }
  richer_ += std::log(std::max(key.texture, kLeastTexture)) > log_texture_ ? 1 : 0;
  ++seen_;
}

void NoiseModel::learn(double dt_s) {
  const double forget = std::exp(-std::max(dt_s, 0.0) / kMemory_s);
  common_.pixel.learn(forget);
  common_.disparity.learn(forget);
  for (Bin& bin : bins_) {
    // A bin of which nothing is known any more begins where all are.
    if (bin.pixel.weight < kLeastWeight) bin.pixel.log_factor = common_.pixel.log_factor;
    if (bin.disparity.weight < kLeastWeight)
      bin.disparity.log_factor = common_.disparity.log_factor;
    bin.pixel.learn(forget);
    bin.disparity.learn(forget);
  }
  texture_weight_ *= forget;
  if (seen_ == 0) return;
  texture_weight_ += seen_;
  log_texture_ +=
      seen_ / texture_weight_ * kTextureGain * (static_cast<double>(richer_) / seen_ - 0.5);
  richer_ = seen_ = 0;
}

void NoiseModel::report(std::vector<NoiseBin>& bins) const {
  bins.clear();
  for (std::size_t i = 0; i < kBins; ++i) {
    const Bin& bin = bins_[i];
    if (bin.disparity.weight < kLeastWeight) continue;
    const std::size_t depth = i / 4;
    const double pixel = shrunk(bin.pixel, common_.pixel);
    const double disparity = shrunk(bin.disparity, common_.disparity);
    bins.push_back(
        {.least_depth_m = depth == 0 ? 0.0 : kDepthEdges_m[depth - 1],
         .most_depth_m = depth + 1 == kDepths ? 0.0 : kDepthEdges_m[depth],
         .is_rich = (i & 2U) != 0,
         .is_old = (i & 1U) != 0,
         .weight = bin.disparity.weight,
         .pixel_factor = pixel,
         .disparity_factor = disparity,
         .pixel_sigma_px = std::sqrt(pixel * bin.pixel.variance_px2 + floor_px2_),
         .disparity_sigma_px = std::sqrt(disparity * bin.disparity.variance_px2 + floor_px2_)});
  }
}

}  // namespace egomod
