// SPDX-License-Identifier: Apache-2.0
#include "gl_context.hpp"

#include <gmock/gmock.h>

namespace egomod::sim {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string complaint(const char* library) {
  try {
    const GlContext context(library);
  } catch (const GlError& error) {
    return error.what();
  }
  return "none";
}

TEST(GlContext, SaysWhichPackagesAreMissing) {
  EXPECT_THAT(complaint("libEGL-of-nobody.so.1"),
              AllOf(HasSubstr("libEGL-of-nobody.so.1"), HasSubstr("apt-get install"),
                    HasSubstr("libegl1"), HasSubstr("libgl1-mesa-dri")));
}

TEST(GlContext, SaysSoWhenTheLibraryIsAnotherOne) {
  EXPECT_THAT(complaint("libm.so.6"), AllOf(HasSubstr("eglGetProcAddress"), HasSubstr("libegl1")));
}

TEST(GlContext, OpensWhereThePackagesAre) { EXPECT_EQ(complaint(GlContext::kLibrary), "none"); }

}  // namespace
}  // namespace egomod::sim
