// SPDX-License-Identifier: Apache-2.0
#include "yardstick.hpp"

#include <algorithm>
#include <ctime>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <vector>

namespace egomod::bench {
namespace {

constexpr int kFeatures = 1000;
constexpr int kRuns = 15;

cv::Mat wrapped(const Image& image) {
  return {image.height_px(), image.width_px(), CV_8U, const_cast<std::uint8_t*>(image.row(0)),
          static_cast<std::size_t>(image.stride_bytes())};
}

}  // namespace

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double measure_yardstick_s(const StereoPair& pair) {
  cv::setNumThreads(1);
  const auto orb = cv::ORB::create(kFeatures);
  std::vector<double> times_s;
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
  for (int run = 0; run < kRuns; ++run) {
    const double start_s = cpu_seconds();
    for (const Image* image : {&pair.left, &pair.right})
      orb->detectAndCompute(wrapped(*image), cv::noArray(), points, descriptors);
    times_s.push_back(cpu_seconds() - start_s);
  }
  std::nth_element(times_s.begin(), times_s.begin() + kRuns / 2, times_s.end());
  return times_s[kRuns / 2];
}

}  // namespace egomod::bench
