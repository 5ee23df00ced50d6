// SPDX-License-Identifier: Apache-2.0
#include "egomod/core/instruction_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

namespace egomod {
namespace {

class InstructionSetVariable : public ::testing::Test {
 protected:
  static void set(const char* value) { setenv(kInstructionSetVariable, value, 1); }
  void TearDown() override { unsetenv(kInstructionSetVariable); }
};

TEST_F(InstructionSetVariable, NamesAreReadBack) {
  for (const auto set :
       {InstructionSet::kBaseline, InstructionSet::kX86_64V3, InstructionSet::kX86_64V4}) {
    EXPECT_EQ(instruction_set_named(name(set)), set);
  }
  EXPECT_EQ(instruction_set_named("avx"), std::nullopt);
}

TEST_F(InstructionSetVariable, NarrowsWhatIsUsed) {
  set("baseline");
  EXPECT_EQ(instruction_set(), InstructionSet::kBaseline);
}

TEST_F(InstructionSetVariable, DoesNotWidenIt) {
  unsetenv(kInstructionSetVariable);
  const InstructionSet widest = instruction_set();
  set("x86-64-v4");
  EXPECT_EQ(instruction_set(), widest);
  set("x86-64-v3");
  EXPECT_EQ(instruction_set(), std::min(widest, InstructionSet::kX86_64V3));
}

}  // namespace
}  // namespace egomod
