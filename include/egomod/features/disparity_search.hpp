// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "egomod/features/image_point.hpp"
#include "egomod/features/pyramid.hpp"

namespace egomod {

enum class MatchStatus : std::uint8_t {
  kFound,
  kOutside,    // the patch or the whole search range leaves the image
  kWeak,       // nothing looks alike, or nothing to look at
  kAmbiguous,  // a second place looks almost as alike: repeated texture, a line along the search
};

struct DisparityConfig {
  int max_disparity_px = 256;
  float min_ncc = 0.75F;
  float min_margin = 0.03F;  // NCC above the second best peak
  float max_ratio = 0.5F;    // of 1 - NCC, to that of the second best peak
};

struct DisparityMatch {
  MatchStatus status = MatchStatus::kWeak;
  std::int16_t disparity_px = 0;   // u_left - u_right; -1 allowed, since noise at infinity makes it
  std::int16_t row_offset_px = 0;  // v_right - v_left, -1..1
  float ncc = -1.0F;
  float second_ncc = -1.0F;  // best peak elsewhere (more than 3 px away)
};

// Whole-pixel disparity of corners by zero-mean normalised cross-correlation of 11x11 patches along
// the row and its two neighbours: every disparity at half resolution, the best few peaks again at
// full; what is found must lead back to where it came from. Threads: one caller.
class DisparitySearch {
 public:
  static constexpr int kPatch_px = 11;

  explicit DisparitySearch(const DisparityConfig& config);

  // Both pyramids need two levels (else every corner is kOutside). `matches` is parallel to
  // `corners`, and so is `right_shifts`, unless it is empty: how far the right image shows each
  // corner displaced, whatever its disparity. Matches come without that shift.
  void search(const Pyramid& left, const Pyramid& right, std::span<const PixelPosition> corners,
              std::span<DisparityMatch> matches, std::span<const PixelPosition> right_shifts = {});

 private:
  DisparityConfig config_;
  std::vector<float> strip_;
  std::vector<float> ncc_;
};

}  // namespace egomod
