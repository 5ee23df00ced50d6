// SPDX-License-Identifier: Apache-2.0
// Renders the robot that the rig follows, once at build time for all tests that start programs on
// it. Usage: write_test_sequence FOLDER WIDTH_PX RATE_HZ PAIRS
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>

#include "kitti_writer.hpp"
#include "scenes.hpp"

int main(int argc, char** argv) {
  namespace support = egomod::test_support;
  if (argc != 5) {
    std::fprintf(stderr, "usage: write_test_sequence FOLDER WIDTH_PX RATE_HZ PAIRS\n");
    return 2;
  }
  try {
    const std::filesystem::path folder = argv[1];
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    const support::SyntheticWorld world(support::following_robot(),
                                        support::kinect_pair(std::atoi(argv[2])));
    support::write_kitti_sequence(
        world, {.rate_hz = std::atof(argv[3]), .pairs = std::atoi(argv[4])}, folder);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "write_test_sequence: %s\n", error.what());
    return 1;
  }
}
