// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "egomod/core/image.hpp"
#include "egomod/features/image_point.hpp"

namespace egomod {

// The two kinds that are never matched with each other.
enum class CornerKind : std::uint8_t {
  kDark,
  kBright
};  // darker or brighter than its surroundings

struct Corner {
  PixelPosition position;
  CornerKind kind = CornerKind::kDark;
  int rank = 0;              // 0: the best new corner of its bucket; -1: where few tracks move
  float min_eigenvalue = 0;  // mean structure tensor of 7x7 gradients (grey/px)^2, noise removed
};

struct CornerConfig {
  int bucket_px = 40;           // side of a bucket
  int corners_per_bucket = 6;   // old and new ones together
  int min_distance_px = 7;      // between any two; at most kMaxDistance_px
  int border_px = 8;            // at least kCornerMargin_px
  int min_contrast = 3;         // grey levels between a corner and its surroundings
  float min_eigenvalue = 0.7F;  // (grey/px)^2
};

inline constexpr int kCornerMargin_px = 5;  // what the window and its gradients reach

// Finds new corners where tracks are missing: segment test on a circle of radius 3 (E. Rosten,
// T. Drummond, Machine learning for high-speed corner detection, ECCV 2006) in the buckets with
// room, then the smaller eigenvalue of the structure tensor (J. Shi, C. Tomasi, Good features to
// track, CVPR 1994) at the local maxima. The thresholds rise with the noise measured in the image,
// which is taken out of the structure tensor: noise feigns texture. Threads: one caller.
class CornerDetector {
 public:
  explicit CornerDetector(const CornerConfig& config);

  // Refills `corners` with new ones for the buckets that `occupied` (existing tracks) leaves room
  // in. Order: by rank, then by falling min_eigenvalue, so that a caller who stops anywhere but
  // among those of rank -1 has an even coverage. `room_factor` times as many as there is room for,
  // since some will not find a partner.
  // Unless there are no tracks at all, a bucket that has not just lost some, so that kManyLost are
  // missing, waits for its turn, every kPatience-th call.
  // `movers`: tracks that move on their own. What shows few of them comes first, up to
  // kMostForMovers corners, in the upper buckets until these are full, since what is behind it has
  // more and stronger corners to show, and a caller has few tracks to give.
  void detect(const ImageView& image, std::span<const ImagePoint> occupied, float room_factor,
              std::vector<Corner>& corners, std::span<const ImagePoint> movers = {});

  static constexpr int kPatience = 2;
  static constexpr int kManyLost = 2;
  static constexpr int kMostForMovers = 20;  // corners that come first
  static constexpr int kMaxDistance_px = 8;

 private:
  struct Bucket {
    int u0 = 0, v0 = 0, u1 = 0, v1 = 0;
    int wanted = 0;
    int wanted_before = 0;
    int movers_around = 0;  // in it and in its neighbours
  };

  void lay_out(const ImageView& image);
  void occupy(std::span<const ImagePoint> points);
  [[nodiscard]] Bucket* bucket_at(int u, int v);
  void attend_to(std::span<const ImagePoint> movers);
  void spare_what_can_wait();
  void lay_out_disc();
  void block(int u, int v);
  void search(const ImageView& image, const Bucket& bucket, int wanted,
              std::vector<Corner>& corners);
  void collect_hits(const Bucket& bucket);
  void keep_strongest_hits(int wanted);
  void score_hits(const ImageView& image, const Bucket& bucket);
  void select(const Bucket& bucket, int wanted, std::vector<Corner>& corners);
  [[nodiscard]] std::ptrdiff_t bucket_stride() const { return 2 * config_.bucket_px + 64; }

  CornerConfig config_;
  float noise_sigma_ = 0.0F;  // standard deviation of the grey values that is taken for noise
  unsigned calls_ = 0;
  int for_movers_ = 0;  // corners of this call
  int width_px_ = 0;
  int height_px_ = 0;
  int columns_ = 0;
  std::vector<Bucket> buckets_;  // rows of `columns_`
  using DiscRow = std::array<std::uint8_t, 16>;
  std::vector<DiscRow> disc_;           // of the least distance around a point
  std::vector<std::uint8_t> blocked_;   // pixels too near to a track
  std::vector<std::uint8_t> contrast_;  // segment test of one bucket, with a margin of one pixel
  std::vector<std::uint8_t> bright_;
  std::vector<std::uint8_t> peaks_;  // one row
  std::vector<std::uint64_t> hits_;  // of one bucket; see hit_key
  std::vector<Corner> scored_;
};

}  // namespace egomod
