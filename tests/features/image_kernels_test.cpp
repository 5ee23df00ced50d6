// SPDX-License-Identifier: Apache-2.0
#include "image_kernels.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <ostream>
#include <random>
#include <set>
#include <utility>

#include "correlation.hpp"
#include "egomod/features/descriptor.hpp"
#include "reference_kernels.hpp"
#include "test_images.hpp"

namespace egomod {
namespace {

using testing::flat_image;

// Noise that reaches both ends of the grey scale, so that saturation shows.
Image rough_image(int width_px, int height_px, unsigned seed) {
  return flat_image(width_px, height_px, 128.0, 90.0, seed);
}

Image smooth_image(int width_px, int height_px, unsigned seed) {
  const testing::SpottedTexture texture(width_px, height_px, seed);
  return testing::painted(width_px, height_px, texture);
}

struct NamedKernels {
  const char* name;
  ImageKernels kernels;
};

// Else GoogleTest prints bytes, pointers among them, which change from run to run.
void PrintTo(const NamedKernels& set, std::ostream* out) { *out << set.name; }

std::vector<NamedKernels> all_kernels() {
  std::vector<NamedKernels> sets{{"baseline", baseline::image_kernels()}};
#if defined(EGOMOD_HAS_X86_64_V3)
  if (instruction_set() >= InstructionSet::kX86_64V3)
    sets.push_back({"x86_64_v3", x86_64_v3::image_kernels()});
#endif
  return sets;
}

class ImageKernelsTest : public ::testing::TestWithParam<NamedKernels> {
 protected:
  const ImageKernels& kernels() const { return GetParam().kernels; }
};

INSTANTIATE_TEST_SUITE_P(EverySet, ImageKernelsTest, ::testing::ValuesIn(all_kernels()),
                         [](const auto& set) { return set.param.name; });

TEST_P(ImageKernelsTest, HalvingEqualsTheBinomialBitByBit) {
  for (const int width : {32, 33, 95, 131}) {
    const Image image = rough_image(width, 5, 7);
    const std::uint8_t* const rows[4] = {image.row(1), image.row(2), image.row(3), image.row(4)};
    std::vector<std::uint16_t> scratch(static_cast<std::size_t>(width) + 2);
    Image half(width / 2, 1);
    kernels().halve(rows, width, scratch.data(), half.row(0));
    for (int u = 0; u < width / 2; ++u)
      ASSERT_EQ(half.row(0)[u], testing::reference_half_pixel(image.view(), u, 1))
          << width << " " << u;
  }
}

TEST_P(ImageKernelsTest, SegmentTestEqualsItsDefinitionBitByBit) {
  for (const Image& image : {rough_image(160, 60, 3), smooth_image(160, 60, 3)}) {
    constexpr int margin = 5, count = 150, threshold = 6;
    std::vector<std::uint8_t> contrast(padded_count(count)), bright(contrast.size());
    for (int v = margin; v + margin < 60; ++v) {
      kernels().segment_contrast(image.row(v) + margin, image.stride_bytes(), count, threshold,
                                 contrast.data(), bright.data());
      for (int i = 0; i < count; ++i) {
        const auto wanted = testing::reference_segment_test(image.view(), margin + i, v, threshold);
        const auto at = static_cast<std::size_t>(i);
        ASSERT_EQ(contrast[at], wanted.contrast) << i << " " << v;
        if (wanted.contrast > 0) {
          ASSERT_EQ(bright[at] != 0, wanted.bright) << i << " " << v;
        }
      }
    }
  }
}

TEST_P(ImageKernelsTest, SegmentTestFindsWhatOpenCvFindsAsFast9) {
  constexpr int width = 200, height = 100, margin = 3, threshold = 8;
  const Image image = smooth_image(width, height, 11);
  cv::Mat wrapped(height, width, CV_8U, const_cast<std::uint8_t*>(image.row(0)),
                  static_cast<std::size_t>(image.stride_bytes()));
  std::vector<cv::KeyPoint> points;
  cv::FAST(wrapped, points, threshold, false, cv::FastFeatureDetector::TYPE_9_16);
  std::set<std::pair<int, int>> wanted, found;
  for (const auto& p : points) wanted.emplace(static_cast<int>(p.pt.x), static_cast<int>(p.pt.y));
  std::vector<std::uint8_t> contrast(padded_count(width)), bright(contrast.size());
  for (int v = margin; v + margin < height; ++v) {
    kernels().segment_contrast(image.row(v) + margin, image.stride_bytes(), width - 2 * margin,
                               threshold, contrast.data(), bright.data());
    for (int i = 0; i < width - 2 * margin; ++i)
      if (contrast[static_cast<std::size_t>(i)] > 0) found.emplace(margin + i, v);
  }
  EXPECT_GT(wanted.size(), 100U);
  EXPECT_EQ(found, wanted);
}

TEST_P(ImageKernelsTest, PeaksEqualTheirDefinitionBitByBit) {
  constexpr int count = 120;
  // Few grey values, so that plateaus occur.
  const Image image = testing::flat_image(160, 40, 3.0, 1.5, 8);
  const Image veto = testing::flat_image(160, 40, -0.5, 1.0, 9);
  std::vector<std::uint8_t> peaks(padded_count(count));
  for (int v = 1; v < 39; ++v) {
    kernels().peaks(image.row(v) + 1, image.stride_bytes(), veto.row(v) + 1, count, peaks.data());
    for (int i = 0; i < count; ++i) {
      const auto at = [&](int du, int dv) { return image.row(v + dv)[1 + i + du]; };
      const int before = std::max({at(-1, -1), at(0, -1), at(1, -1), at(-1, 0)});
      const int after = std::max({at(1, 0), at(-1, 1), at(0, 1), at(1, 1)});
      const bool is_peak = veto.row(v)[1 + i] == 0 && at(0, 0) > before && at(0, 0) >= after;
      ASSERT_EQ(peaks[static_cast<std::size_t>(i)], is_peak ? at(0, 0) : 0) << i << " " << v;
    }
  }
}

TEST_P(ImageKernelsTest, WindowSumsEqualTheirDefinitionBitByBit) {
  const Image image = rough_image(40, 40, 5);
  for (int v = 5; v < 34; ++v) {
    for (int u = 5; u < 34; ++u) {
      const WindowSums sums = kernels().window_sums(image.row(v) + u, image.stride_bytes());
      const auto wanted = testing::reference_window_sums(image.view(), u, v);
      ASSERT_EQ(sums.xx, wanted.xx);
      ASSERT_EQ(sums.xy, wanted.xy);
      ASSERT_EQ(sums.yy, wanted.yy);
      ASSERT_EQ(sums.noise, wanted.noise);
    }
  }
}

template <int kSide>
std::vector<float> correlated(void (*kernel)(const Correlation&, float*), const Image& image,
                              int count) {
  const CorrelationPatch<kSide> patch(image.row(10) + 20, image.stride_bytes());
  const std::ptrdiff_t stride = strip_stride(count, kSide);
  std::vector<float> strip(static_cast<std::size_t>(stride * kSide));
  std::vector<float> ncc(static_cast<std::size_t>(padded_count(count)));
  copy_strip(image.view(), 3, 10, count + kSide - 1, kSide, strip.data(), stride);
  kernel(patch.along(strip.data(), stride, count), ncc.data());
  ncc.resize(static_cast<std::size_t>(count));
  return ncc;
}

template <int kSide>
void expect_reference(const std::vector<float>& ncc, const Image& image) {
  constexpr double kFloatRounding = 2e-6;
  for (std::size_t i = 0; i < ncc.size(); ++i)
    ASSERT_NEAR(ncc[i],
                testing::reference_ncc(image.view(), 20, 10, image.view(), 3 + static_cast<int>(i),
                                       10, kSide),
                kFloatRounding)
        << i;
}

TEST_P(ImageKernelsTest, CorrelationEqualsItsDefinition) {
  for (const Image& image : {rough_image(400, 40, 9), smooth_image(400, 40, 9)}) {
    for (const int count : {1, 8, 17, 33, 300}) {
      expect_reference<8>(correlated<8>(kernels().correlate_8, image, count), image);
      expect_reference<11>(correlated<11>(kernels().correlate_11, image, count), image);
    }
  }
}

TEST_P(ImageKernelsTest, CorrelationGivesTheBitsOfTheBaseline) {
  const ImageKernels baseline = baseline::image_kernels();
  const Image image = rough_image(400, 40, 13);
  EXPECT_EQ(correlated<8>(kernels().correlate_8, image, 300),
            correlated<8>(baseline.correlate_8, image, 300));
  EXPECT_EQ(correlated<11>(kernels().correlate_11, image, 300),
            correlated<11>(baseline.correlate_11, image, 300));
}

TEST_P(ImageKernelsTest, CorrelationOfFlatPlacesIsMinusOne) {
  const Image image = flat_image(100, 40, 90.0, 0.0);
  for (const float ncc : correlated<11>(kernels().correlate_11, image, 40)) EXPECT_EQ(ncc, -1.0F);
}

TEST_P(ImageKernelsTest, DescriptorDistancesAreSumsOfAbsoluteDifferences) {
  const Image bytes = rough_image(32, 50, 21);
  const std::vector<std::int32_t> indices{4, 0, 49, 17};
  std::vector<std::int32_t> distances(indices.size());
  kernels().descriptor_distances(bytes.row(3), bytes.row(0), bytes.stride_bytes(), indices.data(),
                                 static_cast<int>(indices.size()), distances.data());
  for (std::size_t k = 0; k < indices.size(); ++k) {
    int wanted = 0;
    for (int i = 0; i < 32; ++i) wanted += std::abs(bytes.row(3)[i] - bytes.row(indices[k])[i]);
    EXPECT_EQ(distances[k], wanted);
  }
}

}  // namespace
}  // namespace egomod
