// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace egomod {

// Kernels are written once, in an .inc file, and compiled once for each instruction set, inside
// that set's namespace. They use nothing inline from other headers: the linker might otherwise keep
// the wide copy of a function that the narrow code calls too. Debian 12's clang (and clang-tidy)
// knows no levels by name: with it the narrow kernels run.
[[nodiscard]] inline bool cpu_has_x86_64_v3() {
#if defined(EGOMOD_HAS_X86_64_V3) && !defined(__clang__)
  return __builtin_cpu_supports("x86-64-v3");
#else
  return false;
#endif
}

[[nodiscard]] inline bool cpu_has_x86_64_v4() {
#if defined(EGOMOD_HAS_X86_64_V3) && !defined(__clang__)
  return __builtin_cpu_supports("x86-64-v4");
#else
  return false;
#endif
}

}  // namespace egomod
