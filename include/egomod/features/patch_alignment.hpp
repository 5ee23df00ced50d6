// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "egomod/core/image.hpp"

namespace egomod {

// Subpixel alignment of patches, 11 wide and 9 high, inverse compositional (S. Baker, I. Matthews,
// Lucas-Kanade 20 Years On, IJCV 2004), Gaussian-weighted, gain and offset free: patches are
// compared after weighted mean and contrast are taken out, and the two are projected out of the
// steepest-descent images. Templates sit on whole pixels, so that building one interpolates
// nothing.
inline constexpr int kPatchRadiusU_px = 5;
inline constexpr int kPatchRadiusV_px = 4;
inline constexpr int kPatchRows = 2 * kPatchRadiusV_px + 1;
inline constexpr int kPatchLanes = 112;  // rows of 12; those that are no pixels have weight zero
// A template needs this distance to the image border: the gradient filter reads two pixels beyond.
inline constexpr int kTemplateMargin_px = kPatchRadiusU_px + 2;

// Parameters = 6: position and 2x2 warp. Parameters = 3: position along the row and the two slopes
// of a disparity plane. Plain arrays: the kernels call no inline function of the library (see
// patch_kernels.cpp).
template <int Parameters>
struct PatchTemplate {
  // Weighted gradients and weighted normalised grey values; only running sums against the warped
  // patch are ever needed, so no residual is formed.
  alignas(64) float weighted_value[kPatchLanes];
  alignas(64) float weighted_gu[kPatchLanes];
  alignas(64) float weighted_gv[Parameters == 6 ? kPatchLanes : 1];
  float mean;
  float contrast;  // weighted standard deviation, grey levels
  // Projections of the steepest-descent images onto offset and gain.
  float on_offset[Parameters];
  float on_gain[Parameters];
  float inverse_hessian[Parameters * Parameters];  // damped
  // Structure tensor of the normalised patch, gain and offset projected out: uu uv vv, 1/px^2.
  float tensor[3];
};

using AffineTemplate = PatchTemplate<6>;
using PlaneTemplate = PatchTemplate<3>;

// Template offset (x, y) is seen at (u + a x + b y, v + c x + d y).
struct AffineWarp {
  float u_px = 0.0F;
  float v_px = 0.0F;
  float a = 1.0F;
  float b = 0.0F;
  float c = 0.0F;
  float d = 1.0F;
};

// Template offset (x, y) is seen in the right image at (u + x (1 - slope_u) - y slope_v, v + y).
struct PlaneWarp {
  float u_px = 0.0F;
  int v_px = 0;
  float slope_u = 0.0F;  // d(disparity) / du
  float slope_v = 0.0F;
};

struct AlignmentResult {
  float ncc = -1.0F;       // of the last evaluation, -1 where the patch leaves the image
  bool converged = false;  // the last position step left little
  float step_u_px = 0.0F;  // the first step of all, along u (closure and consistency checks)
  float step_v_px = 0.0F;
};

// Effective number of samples of the Gaussian window: 1 / sum(w^2).
[[nodiscard]] float patch_effective_samples();

// (u, v) must keep kTemplateMargin_px to the border.
void build_template(const ImageView& image, int u_px, int v_px, AffineTemplate& out);
void build_template(const ImageView& image, int u_px, int v_px, PlaneTemplate& out);

// Moves `warp` to the best fit. Stops at `max_steps` or when a step is too short to matter.
[[nodiscard]] AlignmentResult align(const ImageView& image, const AffineTemplate& patch,
                                    int max_steps, AffineWarp& warp);
[[nodiscard]] AlignmentResult align(const ImageView& image, const PlaneTemplate& patch,
                                    int max_steps, PlaneWarp& warp);

}  // namespace egomod
