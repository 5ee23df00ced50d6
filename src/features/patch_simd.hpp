// SPDX-License-Identifier: Apache-2.0
// Vectors for the patch kernels: 16 lanes with AVX-512, 8 with AVX2, else 4. Included once per
// instruction set, inside that set's namespace, so that no function of a wider set is linked into a
// narrower one.

#if defined(__AVX512BW__)
constexpr int kLanes = 16;
using Float = float __attribute__((vector_size(64)));
using Int = int __attribute__((vector_size(64)));
#elif defined(__AVX2__)
constexpr int kLanes = 8;
using Float = float __attribute__((vector_size(32)));
using Int = int __attribute__((vector_size(32)));
#else
constexpr int kLanes = 4;
using Float = float __attribute__((vector_size(16)));
using Int = int __attribute__((vector_size(16)));
#endif
// One row of pixels of a patch.
using RowBytes = unsigned char __attribute__((vector_size(16)));
using RowShorts = short __attribute__((vector_size(32)));
using RowFloats = float __attribute__((vector_size(64)));

inline Float splat(float x) { return Float{} + x; }
inline Float load(const float* p) {
  Float x;
  __builtin_memcpy(&x, p, sizeof(x));
  return x;
}
inline void store(float* p, Float x) { __builtin_memcpy(p, &x, sizeof(x)); }
inline Int truncated(Float x) { return __builtin_convertvector(x, Int); }
inline Float as_float(Int x) { return __builtin_convertvector(x, Float); }

inline void load_row(const unsigned char* p, RowShorts& row) {
  RowBytes bytes;
  __builtin_memcpy(&bytes, p, sizeof(bytes));
  row = __builtin_convertvector(bytes, RowShorts);
}
inline void store_row(float* p, const RowShorts& row, float scale) {
  const RowFloats floats = __builtin_convertvector(row, RowFloats) * scale;
  __builtin_memcpy(p, &floats, sizeof(floats));
}

inline float sum(Float x) {
  float total = 0.0F;
#if defined(__AVX512BW__)
  const __m256 half = _mm256_add_ps(_mm512_castps512_ps256(x), _mm512_extractf32x8_ps(x, 1));
  __m128 s = _mm_add_ps(_mm256_castps256_ps128(half), _mm256_extractf128_ps(half, 1));
#elif defined(__AVX2__)
  __m128 s = _mm_add_ps(_mm256_castps256_ps128(x), _mm256_extractf128_ps(x, 1));
#elif defined(__SSE4_1__)
  __m128 s = x;
#endif
#if defined(__SSE4_1__)
  s = _mm_add_ps(s, _mm_movehl_ps(s, s));
  total = _mm_cvtss_f32(_mm_add_ss(s, _mm_movehdup_ps(s)));
#else
  for (int i = 0; i < kLanes; ++i) total += x[i];
#endif
  return total;
}

// Cubic convolution (R. Keys, 1981). Its slope at a pixel is -a times the plain difference of the
// neighbours: right for waves of 1.2 rad a pixel with a = -0.65, too steep for longer ones and too
// flat for shorter ones. Where it is too steep, points of one motion all lag behind when they leave
// their pixels: with -0.75 by 12 % of the first tenths of a pixel, on textures of rendered rooms.
constexpr float kCubic = -0.65F;

// Weights of neighbouring pixels.
template <int kTaps>
struct Weights {
  Float w[kTaps];
};
// Of those at -1, 0, 1, 2.
inline Weights<4> cubic_weights(Float f) {
  const Float g = 1.0F - f;
  const Float fg = f * g * kCubic;
  const Float first = fg * g;
  const Float last = fg * f;
  const Float second = f * f * ((kCubic + 2.0F) * f - (kCubic + 3.0F)) + 1.0F;
  return {{first, second, 1.0F - first - second - last, last}};
}

// Cells: four lanes each, which read from 16 pixels of their own. A row of pixels is interpolated
// in every lane at its own place: `index` names the first of the lane's four pixels in its cell.
#if defined(__SSE4_1__)
// Fixed point: two 16-bit products a lane and instruction, weights in 14 bits.
constexpr float kWeightOne = 16384.0F;

inline Int rounded(Float x) {
#if defined(__AVX512BW__)
  return Int(_mm512_cvtps_epi32(x));
#elif defined(__AVX2__)
  return Int(_mm256_cvtps_epi32(x));
#else
  return Int(_mm_cvtps_epi32(x));
#endif
}
// The first and the last two of the pixels of each lane, as 16-bit numbers.
inline Int picked(Int pixels, Int places) {
#if defined(__AVX512BW__)
  return Int(_mm512_shuffle_epi8(__m512i(pixels), __m512i(places)));
#elif defined(__AVX2__)
  return Int(_mm256_shuffle_epi8(__m256i(pixels), __m256i(places)));
#else
  return Int(_mm_shuffle_epi8(__m128i(pixels), __m128i(places)));
#endif
}
inline Int products(Int pixels, Int weights) {
#if defined(__AVX512BW__)
  return Int(_mm512_madd_epi16(__m512i(pixels), __m512i(weights)));
#elif defined(__AVX2__)
  return Int(_mm256_madd_epi16(__m256i(pixels), __m256i(weights)));
#else
  return Int(_mm_madd_epi16(__m128i(pixels), __m128i(weights)));
#endif
}

class RowInterpolator {
 public:
  RowInterpolator(Int index, Float fraction) {
    const Weights<4> at = cubic_weights(fraction);
    // Bytes (index, zero, index + 1, zero) of each lane.
    places_ = index * 0x00010001 + int(0x80018000U);
    const Int w0 = rounded(at.w[0] * kWeightOne);
    const Int w1 = rounded(at.w[1] * kWeightOne);
    const Int w3 = rounded(at.w[3] * kWeightOne);
    first_ = packed(w0, w1);
    last_ = packed(int(kWeightOne) - w0 - w1 - w3, w3);
  }
  // kWeightOne times the interpolated grey value.
  [[nodiscard]] Float operator()(Int pixels) const {
    return as_float(products(picked(pixels, places_), first_) +
                    products(picked(pixels, places_ + 0x00020002), last_));
  }

 private:
  static Int packed(Int low, Int high) { return (low & 0xFFFF) | (high << 16); }

  Int places_;
  Int first_;
  Int last_;
};
#else
constexpr float kWeightOne = 1.0F;

class RowInterpolator {
 public:
  RowInterpolator(Int index, Float fraction) : index_(index), weights_(cubic_weights(fraction)) {}
  [[nodiscard]] Float operator()(Int pixels) const {
    unsigned char bytes[sizeof(Int)];
    __builtin_memcpy(bytes, &pixels, sizeof(bytes));
    Float total{};
    for (int k = 0; k < 4; ++k) {
      Float tap{};
      for (int i = 0; i < kLanes; ++i)
        tap[i] = static_cast<float>(bytes[(i / 4) * 16 + index_[i] + k]);
      total += tap * weights_.w[k];
    }
    return total;
  }

 private:
  Int index_;
  Weights<4> weights_;
};
#endif

// 16 pixels for each cell, from its first lane's offset.
inline Int load_cells(const unsigned char* base, const int* offsets) {
#if defined(__SSE4_1__)
  const auto cell = [&](int k) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(base + offsets[4 * k]));
  };
#endif
#if defined(__AVX512BW__)
  const __m256i low = _mm256_inserti128_si256(_mm256_castsi128_si256(cell(0)), cell(1), 1);
  const __m256i high = _mm256_inserti128_si256(_mm256_castsi128_si256(cell(2)), cell(3), 1);
  return Int(_mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1));
#elif defined(__AVX2__)
  return Int(_mm256_inserti128_si256(_mm256_castsi128_si256(cell(0)), cell(1), 1));
#elif defined(__SSE4_1__)
  return Int(cell(0));
#else
  Int row;
  __builtin_memcpy(&row, base + offsets[0], sizeof(row));
  return row;
#endif
}
