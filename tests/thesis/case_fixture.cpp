// SPDX-License-Identifier: Apache-2.0
#include "case_fixture.hpp"

#include <fmt/format.h>

#include <egomod/object_list_t.hpp>
#include <egomod/pose_t.hpp>
#include <egomod/timing_t.hpp>
#include <egomod/track_list_t.hpp>
#include <filesystem>
#include <fstream>
#include <vector>

#include "egomod/publish/encoded_message.hpp"
#include "egomod/publish/messages.hpp"
#include "egomod/publish/record_writer.hpp"

namespace egomod::thesis {
namespace {

constexpr int kPairs = 31;
constexpr std::int64_t kInterval_us = 100'000;
constexpr double kFocal_px = 500.0;
constexpr double kBaseline_m = 0.4;

double rig_m(int pair) { return 0.05 * pair; }
double depth_m(int pair) { return 5.0 + 0.1 * pair - rig_m(pair); }
double left_px(int pair) { return 320.0 - kFocal_px / depth_m(pair) - 100.0; }

void write_truth(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::ofstream times(folder / "times.txt");
  std::ofstream poses(folder / "poses.txt");
  std::ofstream objects(folder / "objects.csv");
  std::ofstream(folder / "calib.txt") << "P0: 500 0 320 0 0 500 240 0 0 0 1 0\n"
                                         "P1: 500 0 320 -200 0 500 240 0 0 0 1 0\n";
  objects << "frame,time,object_id,class,cx,cy,cz,bx,by,bz,VX,VY,VZ,wx,wy,wz,u_min,v_min,u_max,"
             "v_max,visible_px,moving\n";
  for (int i = 0; i < kPairs; ++i) {
    times << 0.1 * i << '\n';
    poses << fmt::format("1 0 0 0 0 1 0 0 0 0 1 {}\n", rig_m(i));
    objects << fmt::format("{},{},1,pioneer,-1,0,{},-1,0,{},0,0,1,0,0,0,{},100,{},300,9000,1\n", i,
                           0.1 * i, depth_m(i), depth_m(i) + 0.2, left_px(i), left_px(i) + 200.0);
  }
}

class Recording {
 public:
  explicit Recording(const std::filesystem::path& file) : writer_(file) {}

  void calibration() {
    Calibration calibration;
    calibration.camera = {.fx_px = kFocal_px,
                          .fy_px = kFocal_px,
                          .cx_px = 320.0,
                          .cy_px = 240.0,
                          .baseline_m = kBaseline_m};
    calibration_t message{};
    fill_message(calibration, false, message);
    write("EGOMOD_CALIBRATION", message);
  }

  void pose(int pair, bool skipped) {
    pose_t message{};
    stamp(pair, message);
    message.pos[0] = rig_m(skipped ? pair / 10 * 10 : pair);
    message.orientation[0] = 1.0;
    message.status = skipped ? pose_t::STATUS_SKIPPED : pose_t::STATUS_VALID;
    write("EGOMOD_POSE", message);
  }

  void objects(int pair, bool found) {
    object_list_t list{};
    stamp(pair, list);
    if (found) {
      object_t object{};
      object.id = 1;
      object.state = object_t::STATE_MOVING;
      object.body_pos[0] = depth_m(pair) + 0.1;
      object.body_pos[1] = 1.0;
      object.body_vel[0] = 1.25;
      object.u_min = static_cast<float>(left_px(pair));
      object.u_max = static_cast<float>(left_px(pair) + 200.0);
      object.v_min = 100.0F;
      object.v_max = 300.0F;
      object.n_points = 20;
      list.objects.push_back(object);
    }
    list.n_objects = static_cast<std::int32_t>(list.objects.size());
    write("EGOMOD_OBJECTS", list);
  }

  // One point at rest and one on the target, RANSAC agrees.
  void tracks(int pair) {
    track_list_t list{};
    stamp(pair, list);
    const auto add = [&](double u_px, double z_m, float speed_mps, std::int8_t role) {
      track_t track{};
      track.u = static_cast<float>(u_px);
      track.v = 200.0F;
      track.disparity = static_cast<float>(kFocal_px * kBaseline_m / z_m);
      track.role = role;
      track.state = track_t::STATE_STATIC;
      track.vel[0] = speed_mps;
      list.tracks.push_back(track);
    };
    add(600.0, 8.0, 0.1F, track_t::ROLE_INLIER);
    add(left_px(pair) + 50.0, depth_m(pair), 0.5F, track_t::ROLE_OUTLIER);
    list.n_tracks = 2;
    write("EGOMOD_TRACKS", list);
  }

  void timing(int pair, std::int64_t pair_ms) {
    timing_t message{};
    stamp(pair, message);
    const std::int64_t half_ns = pair_ms * 500'000;
    message.stages = {{"features", 0, half_ns}, {"egomotion", half_ns, 2 * half_ns}};
    message.n_stages = 2;
    write("EGOMOD_TIMING", message);
  }

 private:
  template <typename Message>
  static void stamp(int pair, Message& message) {
    message.sequence = pair;
    message.utime = pair * kInterval_us;
  }
  template <typename Message>
  void write(const std::string& channel, const Message& message) {
    writer_.write({channel, message.utime, encode_message(message, buffer_)});
  }

  RecordWriter writer_;
  std::vector<std::uint8_t> buffer_;
};

void write_records(const std::string& folder) {
  Recording thesis(folder + "/thesis.lcmlog");
  Recording standard(folder + "/default.lcmlog");
  thesis.calibration();
  standard.calibration();
  for (int i = 0; i < kPairs; ++i) {
    const bool taken = i % 10 == 0;
    thesis.pose(i, !taken);
    if (taken) {
      thesis.objects(i, i > 0);
      thesis.tracks(i);
      thesis.timing(i, 2);
    }
    standard.pose(i, false);
    standard.objects(i, i >= 5);
    standard.timing(i, 6);
  }
}

}  // namespace

void write_case(const std::string& folder) {
  write_truth(folder + "/truth");
  write_records(folder);
  for (const char* name : {"thesis-narrow", "thesis-wide"}) {
    std::filesystem::copy_file(folder + "/thesis.lcmlog", folder + "/" + name + ".lcmlog");
  }
}

}  // namespace egomod::thesis
