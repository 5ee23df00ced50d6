// SPDX-License-Identifier: Apache-2.0
// What is known of a patch before it is looked for: its pixels and gradients, normalised, and the
// Hessian of its alignment. Included once per instruction set, as patch_simd.hpp is, and after it.

// exp(-k^2 / (2 * 3^2)), k = 0..5: the window's standard deviation is 3 px.
constexpr float kWindow[6] = {1.0F,         0.945959469F, 0.800737403F,
                              0.606530660F, 0.411112291F, 0.249352209F};

// The patch, row by row, in cells of four neighbours; the last cell of a row has one lane of weight
// zero, and so have the cells that fill up the last vector.
constexpr int kRowLanes = 12;
struct Lanes {
  alignas(64) float x[kPatchLanes];
  alignas(64) float y[kPatchLanes];
  alignas(64) float first_x[kPatchLanes];  // of the lane's cell
  alignas(64) float weight[kPatchLanes];
};

constexpr Lanes make_lanes() {
  Lanes lanes{};
  float total = 0.0F;
  for (int i = 0; i < kPatchLanes; ++i) {
    const int row = i / kRowLanes;
    const int x = i % kRowLanes - kPatchRadiusU_px;
    const int y = row < kPatchRows ? row - kPatchRadiusV_px : 0;
    const bool used = row < kPatchRows && x <= kPatchRadiusU_px;
    lanes.x[i] = static_cast<float>(x);
    lanes.y[i] = static_cast<float>(y);
    lanes.first_x[i] = static_cast<float>(x - i % 4);
    lanes.weight[i] = used ? kWindow[x < 0 ? -x : x] * kWindow[y < 0 ? -y : y] : 0.0F;
    total += lanes.weight[i];
  }
  for (float& w : lanes.weight) w /= total;
  return lanes;
}
constexpr Lanes kLane = make_lanes();

// Inverse of a symmetric positive definite matrix by Cholesky: S = L L^T, S^-1 = L^-T L^-1.
template <int N>
void invert_symmetric(const float* S, float* inverse) {
  float L[N][N] = {};
  float M[N][N] = {};  // L^-1
  for (int j = 0; j < N; ++j) {
    for (int i = j; i < N; ++i) {
      float s = S[i * N + j];
      for (int k = 0; k < j; ++k) s -= L[i][k] * L[j][k];
      L[i][j] = i == j ? __builtin_sqrtf(s > 1e-12F ? s : 1e-12F) : s / L[j][j];
    }
    M[j][j] = 1.0F / L[j][j];
  }
  for (int j = 0; j < N; ++j) {
    for (int i = j + 1; i < N; ++i) {
      float s = 0.0F;
      for (int k = j; k < i; ++k) s -= L[i][k] * M[k][j];
      M[i][j] = s * M[i][i];
    }
  }
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j <= i; ++j) {
      float s = 0.0F;
      for (int k = i; k < N; ++k) s += M[k][i] * M[k][j];
      inverse[i * N + j] = inverse[j * N + i] = s;
    }
  }
}

// gv: of affine patches only.
struct PatchPixels {
  alignas(64) float value[kPatchLanes];
  alignas(64) float gu[kPatchLanes];
  alignas(64) float gv[kPatchLanes];
};

// Central difference over half a pixel each way of the cubic interpolant, times 32.
inline void gradient(const unsigned char* p, long step, RowShorts& out) {
  RowShorts far_behind, behind, ahead, far_ahead;
  load_row(p - 2 * step, far_behind);
  load_row(p - step, behind);
  load_row(p + step, ahead);
  load_row(p + 2 * step, far_ahead);
  out = (ahead - behind) * 22 - (far_ahead - far_behind) * 3;
}

// Each row is read and written four lanes too far; the next one, or zeros, cover them.
template <int P>
void read_patch(const ImageView& image, int u, int v, PatchPixels& out) {
  const long stride = image.stride_bytes;
  for (int y = 0; y < kPatchRows; ++y) {
    const unsigned char* row =
        image.data + (v + y - kPatchRadiusV_px) * stride + (u - kPatchRadiusU_px);
    const int i = y * kRowLanes;
    RowShorts pixels;
    load_row(row, pixels);
    store_row(out.value + i, pixels, 1.0F);
    gradient(row, 1, pixels);
    store_row(out.gu + i, pixels, 1.0F / 32.0F);
    if constexpr (P == 6) {
      gradient(row, stride, pixels);
      store_row(out.gv + i, pixels, 1.0F / 32.0F);
    }
  }
  for (int i = kPatchRows * kRowLanes; i < kPatchLanes; ++i)
    out.value[i] = out.gu[i] = out.gv[i] = 0.0F;
}

// Weighted mean taken out, divided by the weighted standard deviation. The small constant keeps a
// flat patch finite.
template <int P>
void normalise(PatchPixels& pixels, PatchTemplate<P>& out) {
  Float mean{};
  for (int i = 0; i < kPatchLanes; i += kLanes) {
    mean += load(kLane.weight + i) * load(pixels.value + i);
  }
  out.mean = sum(mean);
  Float power{};
  for (int i = 0; i < kPatchLanes; i += kLanes) {
    const Float e = load(pixels.value + i) - out.mean;
    power += load(kLane.weight + i) * e * e;
  }
  out.contrast = __builtin_sqrtf(sum(power) + 1e-3F);
  const float scale = 1.0F / out.contrast;
  for (int i = 0; i < kPatchLanes; i += kLanes) {
    const Float w = load(kLane.weight + i);
    const Float value = (load(pixels.value + i) - out.mean) * scale;
    const Float gu = load(pixels.gu + i) * scale;
    store(pixels.value + i, value);
    store(pixels.gu + i, gu);
    store(out.weighted_value + i, w * value);
    store(out.weighted_gu + i, w * gu);
    if constexpr (P == 6) {
      const Float gv = load(pixels.gv + i) * scale;
      store(pixels.gv + i, gv);
      store(out.weighted_gv + i, w * gv);
    }
  }
}

// Steepest-descent images are gradients times (1, x, y); with both gradients their products reduce
// to moments of three gradient products.
template <int P>
void parameter_images(const PatchPixels& p, int i, Float (&J)[P]) {
  const Float x = load(kLane.x + i);
  const Float y = load(kLane.y + i);
  const Float gu = load(p.gu + i);
  if constexpr (P == 3) {
    J[0] = gu;
    J[1] = gu * x;
    J[2] = gu * y;
  } else {
    const Float gv = load(p.gv + i);
    J[0] = gu;
    J[1] = gv;
    J[2] = gu * x;
    J[3] = gu * y;
    J[4] = gv * x;
    J[5] = gv * y;
  }
}

// Weak priors, in units of the residual variance of a good match (2e-3): the affine part of each
// step 0.02, the disparity slopes 0.3 along u and 0.6 along v (a floor at 0.6 m height has 0.6).
constexpr float kAffineDamping = 2e-3F / (0.02F * 0.02F);
constexpr float kSlopeUDamping = 2e-3F / (0.3F * 0.3F);
constexpr float kSlopeVDamping = 2e-3F / (0.6F * 0.6F);

template <int P>
constexpr float damping(int k) {
  if constexpr (P == 3) return k == 0 ? 1e-6F : (k == 1 ? kSlopeUDamping : kSlopeVDamping);
  return k < 2 ? 1e-6F : kAffineDamping;
}

template <int P>
void accumulate_hessian(const PatchPixels& pixels, PatchTemplate<P>& out) {
  constexpr int kPairs = P * (P + 1) / 2;
  Float H[kPairs] = {};
  Float on_offset[P] = {};
  Float on_gain[P] = {};
  for (int i = 0; i < kPatchLanes; i += kLanes) {
    Float J[P];
    parameter_images<P>(pixels, i, J);
    const Float w = load(kLane.weight + i);
    const Float value = load(pixels.value + i);
    for (int r = 0, n = 0; r < P; ++r) {
      const Float wJ = w * J[r];
      on_offset[r] += wJ;
      on_gain[r] += wJ * value;
      for (int c = 0; c <= r; ++c, ++n) H[n] += wJ * J[c];
    }
  }
  for (int r = 0; r < P; ++r) {
    out.on_offset[r] = sum(on_offset[r]);
    out.on_gain[r] = sum(on_gain[r]);
  }
  float full[P * P];
  for (int r = 0, n = 0; r < P; ++r) {
    for (int c = 0; c <= r; ++c, ++n) {
      full[r * P + c] = full[c * P + r] =
          sum(H[n]) - out.on_offset[r] * out.on_offset[c] - out.on_gain[r] * out.on_gain[c];
    }
  }
  out.tensor[0] = full[0];
  out.tensor[1] = P == 6 ? full[1] : 0.0F;
  out.tensor[2] = P == 6 ? full[P + 1] : 0.0F;
  for (int k = 0; k < P; ++k) full[k * P + k] += damping<P>(k);
  invert_symmetric<P>(full, out.inverse_hessian);
}

template <int P>
void build(const ImageView& image, int u, int v, PatchTemplate<P>& out) {
  PatchPixels pixels;
  read_patch<P>(image, u, v, pixels);
  normalise<P>(pixels, out);
  accumulate_hessian<P>(pixels, out);
}
