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

inline Float splat(float x) { return Float{} + x; }
inline Int splat_int(int x) { return Int{} + x; }
inline Float load(const float* p) {
  Float x;
  __builtin_memcpy(&x, p, sizeof(x));
  return x;
}
inline void store(float* p, Float x) { __builtin_memcpy(p, &x, sizeof(x)); }
inline Int truncated(Float x) { return __builtin_convertvector(x, Int); }
inline Float as_float(Int x) { return __builtin_convertvector(x, Float); }

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

// Four neighbouring pixels from each lane's offset, as bytes of one 32-bit integer.
inline Int gather_pixels(const unsigned char* base, Int offset) {
#if defined(__AVX512BW__)
  return Int(_mm512_i32gather_epi32(__m512i(offset), base, 1));
#elif defined(__AVX2__)
  return Int(_mm256_i32gather_epi32(reinterpret_cast<const int*>(base), __m256i(offset), 1));
#else
  Int pixels;
  for (int i = 0; i < kLanes; ++i) {
    int four;
    __builtin_memcpy(&four, base + offset[i], 4);
    pixels[i] = four;
  }
  return pixels;
#endif
}

// Cubic convolution (R. Keys, 1981) with the sharper a = -0.75: on sensor-sampled images, which
// carry aliasing, it measured 0.01 px better than -0.5.
constexpr float kCubic = -0.75F;

// Weights of the pixels at -1, 0, 1, 2 for a fraction f.
struct CubicWeights {
  Float w[4];
};
inline CubicWeights cubic_weights(Float f) {
  const Float g = 1.0F - f;
  const Float fg = f * g * kCubic;
  const Float first = fg * g;
  const Float last = fg * f;
  const Float second = f * f * ((kCubic + 2.0F) * f - (kCubic + 3.0F)) + 1.0F;
  return {{first, second, 1.0F - first - second - last, last}};
}

#if defined(__SSE4_1__)
// Fixed-point pixel rows: two 16-bit products a lane and instruction, weights in 14 bits.
constexpr float kWeightOne = 16384.0F;
struct RowWeights {
  Int w01;
  Int w23;
};
inline Int rounded(Float x) {
#if defined(__AVX512BW__)
  return Int(_mm512_cvtps_epi32(x));
#elif defined(__AVX2__)
  return Int(_mm256_cvtps_epi32(x));
#else
  return Int(_mm_cvtps_epi32(x));
#endif
}
inline RowWeights row_weights(Float f) {
  const CubicWeights weights = cubic_weights(f);
  const Int w0 = rounded(weights.w[0] * kWeightOne);
  const Int w1 = rounded(weights.w[1] * kWeightOne);
  const Int w3 = rounded(weights.w[3] * kWeightOne);
  const Int w2 = int(kWeightOne) - w0 - w1 - w3;
  return {(w0 & 0xFFFF) | (w1 << 16), (w2 & 0xFFFF) | (w3 << 16)};
}
inline Float weighted_row(Int pixels, const RowWeights& weights) {
#if defined(__AVX512BW__)
  const __m512i first_two = _mm512_broadcast_i32x4(
      _mm_setr_epi8(0, -1, 1, -1, 4, -1, 5, -1, 8, -1, 9, -1, 12, -1, 13, -1));
  const __m512i last_two = _mm512_broadcast_i32x4(
      _mm_setr_epi8(2, -1, 3, -1, 6, -1, 7, -1, 10, -1, 11, -1, 14, -1, 15, -1));
  const __m512i first = _mm512_shuffle_epi8(__m512i(pixels), first_two);
  const __m512i second = _mm512_shuffle_epi8(__m512i(pixels), last_two);
  const __m512i products = _mm512_add_epi32(_mm512_madd_epi16(first, __m512i(weights.w01)),
                                            _mm512_madd_epi16(second, __m512i(weights.w23)));
  return as_float(Int(products));
#elif defined(__AVX2__)
  const __m256i first_two = _mm256_broadcastsi128_si256(
      _mm_setr_epi8(0, -1, 1, -1, 4, -1, 5, -1, 8, -1, 9, -1, 12, -1, 13, -1));
  const __m256i last_two = _mm256_broadcastsi128_si256(
      _mm_setr_epi8(2, -1, 3, -1, 6, -1, 7, -1, 10, -1, 11, -1, 14, -1, 15, -1));
  const __m256i first = _mm256_shuffle_epi8(__m256i(pixels), first_two);
  const __m256i second = _mm256_shuffle_epi8(__m256i(pixels), last_two);
  const __m256i products = _mm256_add_epi32(_mm256_madd_epi16(first, __m256i(weights.w01)),
                                            _mm256_madd_epi16(second, __m256i(weights.w23)));
  return as_float(Int(products));
#else
  const __m128i first_two = _mm_setr_epi8(0, -1, 1, -1, 4, -1, 5, -1, 8, -1, 9, -1, 12, -1, 13, -1);
  const __m128i last_two =
      _mm_setr_epi8(2, -1, 3, -1, 6, -1, 7, -1, 10, -1, 11, -1, 14, -1, 15, -1);
  const __m128i first = _mm_shuffle_epi8(__m128i(pixels), first_two);
  const __m128i second = _mm_shuffle_epi8(__m128i(pixels), last_two);
  const __m128i products = _mm_add_epi32(_mm_madd_epi16(first, __m128i(weights.w01)),
                                         _mm_madd_epi16(second, __m128i(weights.w23)));
  return as_float(Int(products));
#endif
}
#else
constexpr float kWeightOne = 1.0F;
using RowWeights = CubicWeights;
inline RowWeights row_weights(Float f) { return cubic_weights(f); }
inline Float weighted_row(Int pixels, const RowWeights& weights) {
  Float total = as_float(pixels & 0xFF) * weights.w[0];
  total += as_float((pixels >> 8) & 0xFF) * weights.w[1];
  total += as_float((pixels >> 16) & 0xFF) * weights.w[2];
  return total + as_float((pixels >> 24) & 0xFF) * weights.w[3];
}
#endif

// The first two of four pixels, interpolated; f in 0..1.
inline Float weighted_two(Int pixels, Float f) {
  const Float first = as_float(pixels & 0xFF);
  return first * kWeightOne + (as_float((pixels >> 8) & 0xFF) - first) * (f * kWeightOne);
}
