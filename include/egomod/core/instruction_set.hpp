// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace egomod {

// Kernels are written once, in an .inc file, and compiled once for each instruction set, inside
// that set's namespace. They use nothing inline from other headers: the linker might otherwise keep
// the wide copy of a function that the narrow code calls too. Debian 12's clang (and clang-tidy)
// knows no levels by name: with it the narrow kernels run.
enum class InstructionSet : std::uint8_t {
  kBaseline,  // what all code is compiled for: x86-64-v2, or arm64
  kX86_64V3,  // AVX2
  kX86_64V4,  // AVX-512
};

// Holds the widest that is used, by name, so that one machine can run what another one does.
inline constexpr const char* kInstructionSetVariable = "EGOMOD_INSTRUCTION_SET";

// The widest that kernels are compiled for and this processor has, within what the variable allows.
[[nodiscard]] InstructionSet instruction_set();

// baseline, x86-64-v3, x86-64-v4
[[nodiscard]] std::string_view name(InstructionSet set);
[[nodiscard]] std::optional<InstructionSet> instruction_set_named(std::string_view name);

}  // namespace egomod
