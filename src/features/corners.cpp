// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/corners.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <tuple>

#include "image_kernels.hpp"
#include "noise.hpp"

namespace egomod {
namespace {

constexpr int kWindowArea_px = 49;
constexpr float kSobelGain = 8.0F;
constexpr float kSobelNoise = 12.0F;  // sum of the mask's squares
// In units of the noise's own share of the structure tensor: what is left of it by chance.
constexpr float kNoiseMargin = 2.0F;
constexpr float kContrastPerSigma = 2.0F;
// Noise mask's energy over gradient energy: 1.5 in white noise whatever its law, hardly 0.3 at a
// corner that a lens has drawn.
constexpr float kMaxNoiseShare = 0.6F;
// In a bucket and those around it. What shows more moving tracks has enough of them.
constexpr int kLeastMovers = 2;
constexpr int kMostMovers = 6;
constexpr int kRankOfMovers = -1;
constexpr int kMinScoredHits = 16;
constexpr int kScoredHitsPerCorner = 4;

float smaller_eigenvalue(float xx, float xy, float yy) {
  return 0.5F * (xx + yy - std::sqrt((xx - yy) * (xx - yy) + 4.0F * xy * xy));
}

bool looks_like_noise(const WindowSums& s) {
  return static_cast<float>(s.noise) > kMaxNoiseShare * static_cast<float>(s.xx + s.yy);
}

float min_eigenvalue(const WindowSums& s) {
  constexpr float scale = 1.0F / (static_cast<float>(kWindowArea_px) * kSobelGain * kSobelGain);
  return scale * smaller_eigenvalue(static_cast<float>(s.xx), static_cast<float>(s.xy),
                                    static_cast<float>(s.yy));
}

float noise_eigenvalue(float sigma) {
  return sigma * sigma * kSobelNoise / (kSobelGain * kSobelGain);
}

// Of the hits, the one with the most contrast has the smallest key, then the upper, the left one.
constexpr int kRowShift = 24;
constexpr int kContrastShift = 48;
constexpr std::uint64_t kMaxContrast = 255;

std::uint64_t hit_key(PixelPosition p, std::uint8_t contrast) {
  return (kMaxContrast - contrast) << kContrastShift |
         static_cast<std::uint64_t>(p.v_px) << kRowShift | static_cast<std::uint64_t>(p.u_px);
}

PixelPosition hit_position(std::uint64_t key) {
  constexpr std::uint64_t mask = (std::uint64_t{1} << kRowShift) - 1;
  return {static_cast<int>(key & mask), static_cast<int>(key >> kRowShift & mask)};
}

// Calls `visit(i)` for each of the row's bytes that is not zero, from left to right. Reads eight at
// a time.
template <typename Visit>
void each_nonzero(const std::uint8_t* row, int width, Visit visit) {
  static_assert(std::endian::native == std::endian::little);
  for (int first = 0; first < width; first += 8) {
    std::uint64_t bytes;
    std::memcpy(&bytes, row + first, sizeof(bytes));
    while (bytes != 0) {
      const int byte = std::countr_zero(bytes) / 8;
      if (first + byte >= width) return;
      visit(first + byte);
      bytes &= ~(std::uint64_t{0xFF} << 8 * byte);
    }
  }
}

}  // namespace

CornerDetector::CornerDetector(const CornerConfig& config) : config_(config) {
  config_.border_px = std::max(config_.border_px, kCornerMargin_px + 1);
  config_.bucket_px = std::clamp(config_.bucket_px, 8, 1024);
  config_.min_distance_px = std::clamp(config_.min_distance_px, 1, kMaxDistance_px);
  lay_out_disc();
  hits_.reserve(static_cast<std::size_t>(config_.bucket_px * config_.bucket_px));
  scored_.reserve(hits_.capacity());
}

void CornerDetector::lay_out(const ImageView& image) {
  if (image.width_px == width_px_ && image.height_px == height_px_) return;
  width_px_ = image.width_px;
  height_px_ = image.height_px;
  buckets_.clear();
  const int border = config_.border_px;
  const int width = width_px_ - 2 * border, height = height_px_ - 2 * border;
  if (width <= 0 || height <= 0) return;
  columns_ = std::max(1, (width + config_.bucket_px / 2) / config_.bucket_px);
  const int rows = std::max(1, (height + config_.bucket_px / 2) / config_.bucket_px);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns_; ++c)
      buckets_.push_back({.u0 = border + width * c / columns_,
                          .v0 = border + height * r / rows,
                          .u1 = border + width * (c + 1) / columns_,
                          .v1 = border + height * (r + 1) / rows});
  const auto pixels = static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_);
  blocked_.resize(pixels + kKernelBlock);
  const auto bucket = static_cast<std::size_t>(bucket_stride() * (3 * config_.bucket_px + 2));
  contrast_.resize(bucket);
  bright_.resize(bucket);
  peaks_.resize(static_cast<std::size_t>(bucket_stride()));
}

void CornerDetector::lay_out_disc() {
  const int r = config_.min_distance_px - 1;
  disc_.assign(static_cast<std::size_t>(2 * r + 1), {});
  for (int y = -r; y <= r; ++y) {
    const int reach = static_cast<int>(std::sqrt(static_cast<float>(r * (r + 1) - y * y + r)));
    for (int x = -reach; x <= reach; ++x)
      disc_[static_cast<std::size_t>(y + r)][static_cast<std::size_t>(x + r)] = 1;
  }
}

// A row of the disc is two words; what they hold beyond the disc is zero.
void CornerDetector::block(int u, int v) {
  const int r = config_.min_distance_px - 1;
  for (int y = std::max(v - r, 0); y <= std::min(v + r, height_px_ - 1); ++y) {
    const DiscRow& disc = disc_[static_cast<std::size_t>(y - v + r)];
    std::uint8_t* const row = blocked_.data() + static_cast<std::ptrdiff_t>(y) * width_px_ + u - r;
    if (u >= r && u + r < width_px_) {
      std::uint64_t words[2], mask[2];
      std::memcpy(words, row, sizeof(words));
      std::memcpy(mask, disc.data(), sizeof(mask));
      words[0] |= mask[0];
      words[1] |= mask[1];
      std::memcpy(row, words, sizeof(words));
      continue;
    }
    for (int x = std::max(0, r - u); x <= std::min(2 * r, width_px_ - 1 - u + r); ++x)
      row[x] |= disc[static_cast<std::size_t>(x)];
  }
}

// Inverts u0 = border + floor(width * c / columns).
CornerDetector::Bucket* CornerDetector::bucket_at(int u, int v) {
  const int width = width_px_ - 2 * config_.border_px, height = height_px_ - 2 * config_.border_px;
  const int x = u - config_.border_px, y = v - config_.border_px;
  if (x < 0 || y < 0 || x >= width || y >= height) return nullptr;
  const int rows = static_cast<int>(buckets_.size()) / columns_;
  const int c = ((x + 1) * columns_ - 1) / width, r = ((y + 1) * rows - 1) / height;
  return &buckets_[static_cast<std::size_t>(r * columns_ + c)];
}

void CornerDetector::occupy(std::span<const ImagePoint> points) {
  std::fill(blocked_.begin(), blocked_.end(), std::uint8_t{0});
  for (Bucket& bucket : buckets_) bucket.wanted = config_.corners_per_bucket;
  for (const ImagePoint& point : points) {
    const auto [u, v] = nearest_pixel(point);
    if (u < 0 || v < 0 || u >= width_px_ || v >= height_px_) continue;
    block(u, v);
    if (Bucket* bucket = bucket_at(u, v)) --bucket->wanted;
  }
  for (Bucket& bucket : buckets_) bucket.wanted = std::max(bucket.wanted, 0);
}

void CornerDetector::attend_to(std::span<const ImagePoint> movers) {
  for (Bucket& bucket : buckets_) bucket.movers_around = 0;
  const int rows = static_cast<int>(buckets_.size()) / columns_;
  for (const ImagePoint& point : movers) {
    const auto [u, v] = nearest_pixel(point);
    const Bucket* const own = bucket_at(u, v);
    if (own == nullptr) continue;
    const auto index = static_cast<int>(own - buckets_.data());
    const int row = index / columns_, column = index % columns_;
    for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows - 1); ++r)
      for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns_ - 1); ++c)
        ++buckets_[static_cast<std::size_t>(r * columns_ + c)].movers_around;
  }
}

void CornerDetector::spare_what_can_wait() {
  ++calls_;
  for (std::size_t i = 0; i < buckets_.size(); ++i) {
    Bucket& bucket = buckets_[i];
    const bool has_lost_many = bucket.wanted > bucket.wanted_before && bucket.wanted >= kManyLost;
    bucket.wanted_before = bucket.wanted;
    if (!has_lost_many && (calls_ + i) % kPatience != 0) bucket.wanted = 0;
  }
}

void CornerDetector::collect_hits(const Bucket& bucket) {
  const ImageKernels kernels = image_kernels();
  const std::ptrdiff_t stride = bucket_stride();
  const int width = bucket.u1 - bucket.u0;
  hits_.clear();
  for (int v = bucket.v0; v < bucket.v1; ++v) {
    const std::uint8_t* const blocked =
        blocked_.data() + static_cast<std::ptrdiff_t>(v) * width_px_ + bucket.u0;
    kernels.peaks(contrast_.data() + (v - bucket.v0 + 1) * stride + 1, stride, blocked, width,
                  peaks_.data());
    each_nonzero(peaks_.data(), width, [&](int i) {
      hits_.push_back(hit_key({bucket.u0 + i, v}, peaks_[static_cast<std::size_t>(i)]));
    });
  }
}

void CornerDetector::keep_strongest_hits(int wanted) {
  const auto limit =
      static_cast<std::size_t>(std::max(kMinScoredHits, kScoredHitsPerCorner * wanted));
  if (hits_.size() <= limit) return;
  std::nth_element(hits_.begin(), hits_.begin() + static_cast<std::ptrdiff_t>(limit), hits_.end());
  hits_.resize(limit);
}

void CornerDetector::score_hits(const ImageView& image, const Bucket& bucket) {
  const ImageKernels kernels = image_kernels();
  const float noise = noise_eigenvalue(noise_sigma_);
  const float least = std::max(config_.min_eigenvalue, kNoiseMargin * noise);
  scored_.clear();
  for (const std::uint64_t hit : hits_) {
    const PixelPosition p = hit_position(hit);
    const WindowSums sums = kernels.window_sums(image.row(p.v_px) + p.u_px, image.stride_bytes);
    const float eigenvalue = min_eigenvalue(sums) - noise;
    if (eigenvalue < least || looks_like_noise(sums)) continue;
    const std::ptrdiff_t at = (p.v_px - bucket.v0 + 1) * bucket_stride() + p.u_px - bucket.u0 + 1;
    const bool bright = bright_[static_cast<std::size_t>(at)] != 0;
    scored_.push_back({.position = p,
                       .kind = bright ? CornerKind::kBright : CornerKind::kDark,
                       .min_eigenvalue = eigenvalue});
  }
}

void CornerDetector::select(const Bucket& bucket, int wanted, std::vector<Corner>& corners) {
  const auto order = [](const Corner& c) {
    return std::tuple(-c.min_eigenvalue, c.position.v_px, c.position.u_px);
  };
  std::sort(scored_.begin(), scored_.end(),
            [&](const Corner& a, const Corner& b) { return order(a) < order(b); });
  const bool shows_few_movers =
      bucket.movers_around >= kLeastMovers && bucket.movers_around <= kMostMovers;
  int rank = 0;
  for (const Corner& corner : scored_) {
    if (rank == wanted) return;
    const PixelPosition p = corner.position;
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(p.v_px) * width_px_ + p.u_px;
    if (blocked_[static_cast<std::size_t>(at)] != 0) continue;
    block(p.u_px, p.v_px);
    corners.push_back(corner);
    const bool first = shows_few_movers && for_movers_ < kMostForMovers;
    for_movers_ += first ? 1 : 0;
    corners.back().rank = first ? kRankOfMovers : rank;
    ++rank;
  }
}

void CornerDetector::search(const ImageView& image, const Bucket& bucket, int wanted,
                            std::vector<Corner>& corners) {
  const ImageKernels kernels = image_kernels();
  const std::ptrdiff_t stride = bucket_stride();
  const int width = bucket.u1 - bucket.u0 + 2;
  const int threshold = std::clamp(static_cast<int>(std::lround(kContrastPerSigma * noise_sigma_)),
                                   config_.min_contrast, 254);
  for (int v = bucket.v0 - 1; v <= bucket.v1; ++v) {
    const std::ptrdiff_t row = (v - bucket.v0 + 1) * stride;
    kernels.segment_contrast(image.row(v) + bucket.u0 - 1, image.stride_bytes, width, threshold,
                             contrast_.data() + row, bright_.data() + row);
  }
  collect_hits(bucket);
  keep_strongest_hits(wanted);
  score_hits(image, bucket);
  select(bucket, wanted, corners);
}

void CornerDetector::detect(const ImageView& image, std::span<const ImagePoint> occupied,
                            float room_factor, std::vector<Corner>& corners,
                            std::span<const ImagePoint> movers) {
  corners.clear();
  lay_out(image);
  if (buckets_.empty()) return;
  attend_to(movers);
  for_movers_ = 0;
  occupy(occupied);
  if (!occupied.empty()) spare_what_can_wait();
  if (calls_ % kPatience == 1 || occupied.empty()) noise_sigma_ = estimate_noise_sigma(image);
  for (Bucket& bucket : buckets_) {
    if (bucket.wanted == 0) continue;
    const auto tries = static_cast<int>(std::ceil(room_factor * static_cast<float>(bucket.wanted)));
    search(image, bucket, tries, corners);
  }
  const auto order = [](const Corner& c) {
    return std::tuple(c.rank, -c.min_eigenvalue, c.position.v_px, c.position.u_px);
  };
  std::sort(corners.begin(), corners.end(),
            [&](const Corner& a, const Corner& b) { return order(a) < order(b); });
}

}  // namespace egomod
