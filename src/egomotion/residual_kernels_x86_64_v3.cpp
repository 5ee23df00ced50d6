// SPDX-License-Identifier: Apache-2.0
#define EGOMOD_INSTRUCTION_SET x86_64_v3
#include "residual_kernels.inc"
