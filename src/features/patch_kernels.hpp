// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "egomod/features/patch_alignment.hpp"

namespace egomod {

struct PatchKernels {
  void (*build_affine)(const ImageView&, int, int, AffineTemplate&);
  void (*build_plane)(const ImageView&, int, int, PlaneTemplate&);
  AlignmentResult (*align_affine)(const ImageView&, const AffineTemplate&, int, AffineWarp&);
  AlignmentResult (*align_plane)(const ImageView&, const PlaneTemplate&, int, PlaneWarp&);
  float (*effective_samples)();
};

namespace baseline {
PatchKernels patch_kernels();
}
namespace x86_64_v3 {
PatchKernels patch_kernels();
}
namespace x86_64_v4 {
PatchKernels patch_kernels();
}

}  // namespace egomod
