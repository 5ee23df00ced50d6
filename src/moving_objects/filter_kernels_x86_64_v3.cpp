// SPDX-License-Identifier: Apache-2.0
#define EGOMOD_INSTRUCTION_SET x86_64_v3
#define EGOMOD_VECTOR_BYTES 32
#include "filter_kernels.inc"
