// SPDX-License-Identifier: Apache-2.0
#include "capture/lcm_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <lcm/lcm-cpp.hpp>
#include <thread>

#include "capture/receive_buffer.hpp"
#include "message_fixture.hpp"

namespace egomod {
namespace {

class LcmSourceTest : public ::testing::Test {
 protected:
  void publish(std::int64_t utime_us, int grey) {
    const auto message = stereo(grey_image(utime_us, grey), grey_image(utime_us, grey + 1));
    bus_.publish("EGOMOD_IMAGES", &message);
  }
  void publish_calibration() {
    const calibration_t message = rectified_calibration();
    bus_.publish("EGOMOD_CALIBRATION", &message);
  }

  lcm::LCM bus_{"memq://"};
  StereoPair pair_;
};

TEST_F(LcmSourceTest, GivesThePairsOfTheBusInOrder) {
  const auto source = open_lcm_source(bus_, {}, "");
  EXPECT_FALSE(source->is_replay());
  EXPECT_THAT(source->notice(), ::testing::HasSubstr("waiting for EGOMOD_CALIBRATION"));
  publish_calibration();
  for (int i = 0; i < 5; ++i) {
    publish(33000 * i, 10 * i);
    ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
    EXPECT_EQ(pair_.sequence, static_cast<std::uint64_t>(i));
    EXPECT_EQ(pair_.utime_us(), 33000 * i);
    EXPECT_EQ(pair_.status, PairStatus::kOk);
    EXPECT_FALSE(pair_.discontinuity);
    EXPECT_EQ(pair_.left.row(5)[5], 10 * i);
    EXPECT_EQ(pair_.right.row(5)[5], 10 * i + 1);
  }
  EXPECT_EQ(source->notice(), "");
}

TEST_F(LcmSourceTest, CountsLostImagesAndMarksHolesAndClockSteps) {
  const auto source = open_lcm_source(bus_, {}, "");
  publish_calibration();
  const std::vector<std::pair<int, bool>> stream{{0, false},      {33000, false},  {66000, false},
                                                 {132000, false}, {5000000, true}, {5033000, false},
                                                 {1000000, true}, {1033000, false}};
  for (const auto& [utime_us, broken] : stream) {
    publish(utime_us, 1);
    ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
    EXPECT_EQ(pair_.discontinuity, broken) << utime_us;
    if (utime_us == 132000) {
      EXPECT_EQ(source->counters().lost_images, 1U);
    }
  }
}

TEST_F(LcmSourceTest, TakesItsFirstCalibrationFromARequestAndRefusesOneThatCannotFit) {
  const auto source = open_lcm_source(bus_, {}, "");
  Calibration calibration;
  calibration.camera = {.fx_px = 90.0,
                        .fy_px = 90.0,
                        .cx_px = 15.5,
                        .cy_px = 11.5,
                        .baseline_m = 0.3,
                        .width_px = kMessageWidth_px,
                        .height_px = kMessageHeight_px};
  std::jthread setter([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    source->set_calibration(calibration);
  });
  publish(0, 1);
  publish(33000, 2);
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_EQ(pair_.calibration.camera.baseline_m, 0.3);
  calibration.camera.width_px += 2;
  EXPECT_THROW(source->set_calibration(calibration), SourceError);
  calibration.camera.width_px -= 2;
  calibration.camera.baseline_m = -1.0;
  EXPECT_THROW(source->set_calibration(calibration), SourceError);
  calibration.camera.baseline_m = 0.4;
  source->set_calibration(calibration);
  publish(66000, 3);
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_EQ(pair_.calibration.camera.baseline_m, 0.4);
}

TEST_F(LcmSourceTest, SurvivesGarbage) {
  const auto source = open_lcm_source(bus_, {}, "");
  publish_calibration();
  std::vector<std::uint8_t> bytes = encoded(stereo(grey_image(0, 1), grey_image(0, 1)));
  for (std::size_t size = 0; size < 80; ++size)
    bus_.publish("EGOMOD_IMAGES", bytes.data(), static_cast<unsigned>(size));
  publish(33000, 1);
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_EQ(pair_.utime_us(), 33000);
  EXPECT_EQ(source->counters().damaged_messages, 80U);
}

TEST_F(LcmSourceTest, TakesTheWheelsAtTheExposureWheneverTheyArrive) {
  const auto source = open_lcm_source(bus_, {}, "");
  publish_calibration();
  for (int i = 0; i < 4; ++i) {
    const odometry_t message = odometry_at(20000 * i, i, 0.01 * i);
    bus_.publish("PIONEER_ODOMETRY", &message);
  }
  const std::string garbage = "no odometry";
  bus_.publish("PIONEER_ODOMETRY", garbage.data(), static_cast<unsigned>(garbage.size()));
  for (int i = 0; i < 3; ++i) {
    publish(30000 * i, 1);
    ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
    ASSERT_TRUE(pair_.wheels);
    EXPECT_NEAR(pair_.wheels->T_wheels_body.translation().x(), 0.015 * i, 1e-12);
  }
}

TEST_F(LcmSourceTest, HasNoWheelsOnceTheOdometryIsOld) {
  const auto source = open_lcm_source(bus_, {}, "");
  publish_calibration();
  for (int i = 0; i < 2; ++i) {
    const odometry_t message = odometry_at(20000 * i, i, 0.01 * i);
    bus_.publish("PIONEER_ODOMETRY", &message);
  }
  publish(30000, 1);
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_TRUE(pair_.wheels);
  publish(300000, 1);
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_FALSE(pair_.wheels);
}

TEST_F(LcmSourceTest, StopsPromptlyWhileWaiting) {
  const auto source = open_lcm_source(bus_, {}, "");
  std::stop_source stop;
  const auto start = std::chrono::steady_clock::now();
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    stop.request_stop();
  });
  EXPECT_EQ(source->next(pair_, stop.get_token()), SourceState::kStopped);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
}

TEST_F(LcmSourceTest, SaysWhyACalibrationOfTheBusCannotBeTaken) {
  const auto source = open_lcm_source(bus_, {}, "");
  calibration_t message = rectified_calibration();
  message.baseline = 0.0;
  bus_.publish("EGOMOD_CALIBRATION", &message);
  while (source->counters().damaged_messages == 0) std::this_thread::yield();
  EXPECT_THAT(source->notice(), ::testing::HasSubstr("cannot be right: the baseline must be"));
}

TEST_F(LcmSourceTest, WarnsOnceOfMessagesWithTwoImagesOfOneCamera) {
  const auto source = open_lcm_source(bus_, {}, "");
  publish_calibration();
  auto images = stereo(grey_image(0, 1), grey_image(0, 2));
  images.image_types[1] = bot_core::images_t::LEFT;
  for (int i = 0; i < 2; ++i) bus_.publish("EGOMOD_IMAGES", &images);
  publish(33000, 1);
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_EQ(pair_.utime_us(), 33000);
  EXPECT_EQ(source->counters().damaged_messages, 2U);
  EXPECT_THAT(
      source->take_warnings(),
      ::testing::ElementsAre(::testing::HasSubstr("EGOMOD_IMAGES holds two images of one")));
  EXPECT_TRUE(source->take_warnings().empty());
}

TEST_F(LcmSourceTest, RejectsAPairOfWhichTheRightImageIsMissingSayingWhy) {
  const auto source = open_lcm_source(bus_, {}, "");
  publish_calibration();
  for (int i = 0; i < 12; ++i) {
    bot_core::images_t message = stereo(grey_image(33000 * i, 1), grey_image(33000 * i, 1));
    message.n_images = 1;
    message.image_types.resize(1);
    message.images.resize(1);
    bus_.publish("EGOMOD_IMAGES", &message);
  }
  ASSERT_EQ(source->next(pair_, {}), SourceState::kPair);
  EXPECT_EQ(pair_.status, PairStatus::kRejected);
  EXPECT_EQ(pair_.fault, PairFault::kNoPartner);
}

TEST(ReceiveBuffer, IsAskedForUnlessTheUrlDoes) {
  EXPECT_EQ(with_receive_buffer("udpm://239.255.76.67:7667?ttl=0"),
            "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=8388608");
  EXPECT_EQ(with_receive_buffer("udpm://239.255.76.67:7667"),
            "udpm://239.255.76.67:7667?recv_buf_size=8388608");
  EXPECT_EQ(with_receive_buffer("udpm://?recv_buf_size=1"), "udpm://?recv_buf_size=1");
  EXPECT_EQ(with_receive_buffer("memq://"), "memq://");
}

TEST(ReceiveBuffer, IsGrantedUpToWhatTheKernelAllows) {
  const std::string url = with_receive_buffer("udpm://239.255.76.67:7667?ttl=0");
  EXPECT_EQ(granted_bytes(url, 212992), 212992);
  EXPECT_EQ(granted_bytes(url, 64L << 20), 8L << 20);
  EXPECT_EQ(granted_bytes("udpm://?recv_buf_size=1000&ttl=0", 212992), 1000);
  EXPECT_EQ(granted_bytes("memq://", 212992), 0) << "not known";
}

TEST(ReceiveBufferWatch, SaysNothingOfABufferThatHoldsTheImages) {
  ReceiveBufferWatch watch(4L << 20);
  EXPECT_EQ(watch.warning({.largest_message_bytes = 1U << 20, .awaited_bytes = 1U << 20}), "");
}

TEST(ReceiveBufferWatch, WarnsOnceOfABufferTooSmallForTheImagesAndThenOfEachLoss) {
  ReceiveBufferWatch watch(212992);
  EXPECT_EQ(watch.warning({}), "");
  EXPECT_THAT(watch.warning({.largest_message_bytes = 614528}),
              ::testing::AllOf(::testing::HasSubstr("614528 bytes"),
                               ::testing::HasSubstr("sysctl -w net.core.rmem_max=8388608")));
  EXPECT_EQ(watch.warning({.largest_message_bytes = 614528}), "");
  EXPECT_THAT(watch.warning({.largest_message_bytes = 614528, .lost_images = 3}),
              ::testing::HasSubstr("3 images got lost so far"));
  EXPECT_EQ(watch.warning({.largest_message_bytes = 614528, .lost_images = 3}), "");
}

TEST(ReceiveBufferWatch, WarnsWhenNoImagesArriveThatMayBeTooLarge) {
  ReceiveBufferWatch watch(212992);
  EXPECT_THAT(watch.warning({.awaited_bytes = 614400}), ::testing::HasSubstr("no images arrive"));
  ReceiveBufferWatch other(212992);
  EXPECT_EQ(other.warning({.awaited_bytes = 100000}), "");
}

TEST(ReceiveBufferWatch, WarnsOfLossesAlsoWhenImagesFit) {
  ReceiveBufferWatch watch(4L << 20);
  EXPECT_NE(watch.warning({.largest_message_bytes = 1U << 20, .lost_images = 1}), "");
}

}  // namespace
}  // namespace egomod
