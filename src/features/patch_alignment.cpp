// SPDX-License-Identifier: Apache-2.0
#include "egomod/features/patch_alignment.hpp"

#include "egomod/core/instruction_set.hpp"
#include "patch_kernels.hpp"

namespace egomod {
namespace {

PatchKernels choose() {
#if defined(EGOMOD_HAS_X86_64_V3)
  const InstructionSet set = instruction_set();
  if (set >= InstructionSet::kX86_64V4) return x86_64_v4::patch_kernels();
  if (set >= InstructionSet::kX86_64V3) return x86_64_v3::patch_kernels();
#endif
  return baseline::patch_kernels();
}

const PatchKernels kKernels = choose();

}  // namespace

float patch_effective_samples() { return kKernels.effective_samples(); }

void build_template(const ImageView& image, int u_px, int v_px, AffineTemplate& out) {
  kKernels.build_affine(image, u_px, v_px, out);
}

void build_template(const ImageView& image, int u_px, int v_px, PlaneTemplate& out) {
  kKernels.build_plane(image, u_px, v_px, out);
}

AlignmentResult align(const ImageView& image, const AffineTemplate& patch, int max_steps,
                      AffineWarp& warp) {
  return kKernels.align_affine(image, patch, max_steps, warp);
}

AlignmentResult align(const ImageView& image, const PlaneTemplate& patch, int max_steps,
                      PlaneWarp& warp) {
  return kKernels.align_plane(image, patch, max_steps, warp);
}

}  // namespace egomod
