// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace egomod::fit {

// A folder of the test's own, and what a fit reads.
class FitFolder : public ::testing::Test {
 protected:
  FitFolder()
      : folder(std::filesystem::path(::testing::TempDir()) /
               ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  ~FitFolder() override { std::filesystem::remove_all(folder); }

  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
    return folder / name;
  }
  template <class Message>
  static void append(lcm::LogFile& log, const std::string& channel, const Message& message) {
    std::vector<unsigned char> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, message.getEncodedSize());
    lcm::LogEvent event{};
    event.channel = channel;
    event.datalen = message.getEncodedSize();
    event.data = bytes.data();
    log.writeEvent(&event);
  }
  // Two pairs are the least; rows: "frame,id,cz,bz,u_min,v_min,u_max,v_max,moving".
  void truth(const std::string& rows) const {
    file("times.txt", "0\n0.1\n");
    file("calib.txt", "P1: 500 0 320 -200 0 500 240 0 0 0 1 0\n");
    std::string text =
        "frame,object_id,cz,bz,u_min,v_min,u_max,v_max,moving,time,class,cx,cy,bx,by,VX,VY,VZ,wx,"
        "wy,wz,visible_px\n";
    std::istringstream lines(rows);
    for (std::string row; std::getline(lines, row);) text += row + ",0,box,0,0,0,0,0,0,0,0,0,0,9\n";
    file("objects.csv", text);
  }

  const std::filesystem::path folder;
};

}  // namespace egomod::fit
