// SPDX-License-Identifier: Apache-2.0
#include "egomod/pipeline/stage_thread.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <stdexcept>

#include "egomod/pipeline/pipeline.hpp"

namespace egomod {
namespace {

TEST(StageThread, runs_with_the_small_stack) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the thread sanitizer enlarges stacks";
#endif
  std::size_t stack_bytes = 0;
  StageThread thread({.name = "small"}, [&] {
    pthread_attr_t attributes;
    pthread_getattr_np(pthread_self(), &attributes);
    pthread_attr_getstacksize(&attributes, &stack_bytes);
    pthread_attr_destroy(&attributes);
  });
  thread.join();
  EXPECT_EQ(stack_bytes, StageThread::kStackBytes);
}

TEST(StageThread, goes_on_and_warns_when_a_processor_does_not_exist) {
  std::atomic<bool> has_run{false};
  StageThread thread({.name = "nowhere", .cpu = 1023}, [&] { has_run = true; });
  thread.join();
  EXPECT_TRUE(has_run);
  EXPECT_NE(thread.warning().find("pipeline.cpus"), std::string::npos);
}

TEST(ParseCpus, takes_none_one_or_one_a_stage) {
  EXPECT_EQ(parse_cpus(""), (std::array{-1, -1, -1, -1, -1}));
  EXPECT_EQ(parse_cpus("3"), (std::array{3, 3, 3, 3, 3}));
  EXPECT_EQ(parse_cpus("0,1,2,3,4"), (std::array{0, 1, 2, 3, 4}));
}

TEST(ParseCpus, refuses_everything_else) {
  for (const char* text : {"a", "1,2", "1,", "-1", "1 2", "0,1,2,3,4,5", "4096"}) {
    EXPECT_THROW((void)parse_cpus(text), std::invalid_argument) << text;
  }
}

}  // namespace
}  // namespace egomod
