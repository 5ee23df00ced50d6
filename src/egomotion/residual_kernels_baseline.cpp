// SPDX-License-Identifier: Apache-2.0
#define EGOMOD_INSTRUCTION_SET baseline
#include "residual_kernels.inc"
