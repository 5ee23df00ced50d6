// SPDX-License-Identifier: Apache-2.0
#include "egomod/core/instruction_set.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace egomod {
namespace {

using namespace std::string_view_literals;

constexpr std::array kNames{"baseline"sv, "x86-64-v3"sv, "x86-64-v4"sv};

InstructionSet of_this_processor() {
#if defined(__x86_64__) && !defined(__clang__)
  if (__builtin_cpu_supports("x86-64-v4")) return InstructionSet::kX86_64V4;
  if (__builtin_cpu_supports("x86-64-v3")) return InstructionSet::kX86_64V3;
#endif
  return InstructionSet::kBaseline;
}

}  // namespace

InstructionSet instruction_set() {
  const char* const widest = std::getenv(kInstructionSetVariable);
  const auto allowed = widest == nullptr ? std::nullopt : instruction_set_named(widest);
  return std::min(of_this_processor(), allowed.value_or(InstructionSet::kX86_64V4));
}

std::string_view name(InstructionSet set) { return kNames[static_cast<std::size_t>(set)]; }

std::optional<InstructionSet> instruction_set_named(std::string_view name) {
  const auto* const found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<InstructionSet>(found - kNames.begin());
}

}  // namespace egomod
