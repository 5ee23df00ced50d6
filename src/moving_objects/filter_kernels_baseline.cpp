// SPDX-License-Identifier: Apache-2.0
#define EGOMOD_INSTRUCTION_SET baseline
#define EGOMOD_VECTOR_BYTES 16
#include "filter_kernels.inc"
