// SPDX-License-Identifier: Apache-2.0
#include "egomod/bus/bus_address.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <vector>

namespace egomod {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Backoff, waits_twice_as_long_each_time_but_never_more_than_30_s) {
  Backoff backoff;
  const Backoff::Clock::time_point begin{};
  std::vector<int> tries_s;
  for (int t_s = 0; t_s < 130; ++t_s) {
    if (!backoff.is_due(begin + t_s * 1s)) continue;
    tries_s.push_back(t_s);
    backoff.note_failure(begin + t_s * 1s);
  }
  EXPECT_THAT(tries_s, ElementsAre(0, 1, 3, 7, 15, 31, 61, 91, 121));
}

TEST(Backoff, begins_anew_after_a_success) {
  Backoff backoff;
  const Backoff::Clock::time_point now{};
  for (int i = 0; i < 5; ++i) backoff.note_failure(now);
  backoff.note_success();
  EXPECT_TRUE(backoff.is_due(now));
  backoff.note_failure(now);
  EXPECT_TRUE(backoff.is_due(now + 1s));
}

// How often liblcm was asked shows in how often it complained.
TEST(BusAddress, is_tried_by_all_its_copies_as_one) {
  const BusAddress address("no-such-provider://");
  const std::vector<BusAddress> copies(5, address);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(address.open(), nullptr);
  const std::string once = ::testing::internal::GetCapturedStderr();
  ::testing::internal::CaptureStderr();
  for (const BusAddress& copy : copies) EXPECT_EQ(copy.open(), nullptr);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_NE(once, "");
}

TEST(BusAddress, tells_a_remedy_that_fits_the_scheme) {
  const auto names_schemes =
      AllOf(HasSubstr("unknown scheme, use udpm://"), Not(HasSubstr("route")));
  for (const char* url : {"foo://", "foo://239.255.76.67:7667", "239.255.76.67:7667", "udp://"}) {
    EXPECT_THAT(BusAddress(url).remedy(), names_schemes) << url;
  }
  const auto names_route = HasSubstr("ip route add 224.0.0.0/4 dev lo");
  EXPECT_THAT(BusAddress("udpm://239.255.76.67:7667?ttl=0").remedy(), names_route);
  EXPECT_THAT(BusAddress("tcpq://localhost:7700").remedy(), HasSubstr("lcm-tcpq-server"));
  ::unsetenv("LCM_DEFAULT_URL");
  EXPECT_THAT(BusAddress().remedy(), names_route);
  ::setenv("LCM_DEFAULT_URL", "foo://", 1);
  EXPECT_THAT(BusAddress().remedy(), names_schemes);
  EXPECT_THAT(BusAddress("udpm://").remedy(), names_route);
  ::unsetenv("LCM_DEFAULT_URL");
}

TEST(BusAddress, opens_for_each_copy_once_it_can_be_opened) {
  const BusAddress address("memq://");
  const BusAddress copy = address;
  EXPECT_NE(address.open(), nullptr);
  EXPECT_NE(copy.open(), nullptr);
}

}  // namespace
}  // namespace egomod
