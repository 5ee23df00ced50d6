// SPDX-License-Identifier: Apache-2.0
#include "egomod/egomotion/ransac.hpp"

namespace egomod {

Sample Sampler::draw(std::size_t count) {
  Sample sample{};
  for (std::size_t k = 0; k < kSampleSize;) {
    sample[k] = generator_() % count;
    const auto drawn = sample.begin() + static_cast<std::ptrdiff_t>(k);
    if (std::find(sample.begin(), drawn, sample[k]) == drawn) ++k;
  }
  return sample;
}

int samples_needed(double inlier_share, double confidence, int max_samples) {
  const double clean = std::pow(std::clamp(inlier_share, 0.0, 1.0), double{kSampleSize});
  if (clean >= confidence) return 1;
  if (clean <= 1e-6) return max_samples;
  const double needed = std::ceil(std::log(1 - confidence) / std::log(1 - clean));
  return static_cast<int>(std::min<double>(needed, max_samples));
}

}  // namespace egomod
