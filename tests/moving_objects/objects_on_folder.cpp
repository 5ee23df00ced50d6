// SPDX-License-Identifier: Apache-2.0
// For developers: capture to moving objects on a folder of stereo pairs, without daemon and bus.
//   objects_on_folder SEQUENCE OUTPUT [thesis|lag|filter] [MAX_RATE_HZ] [fast]
// writes objects.csv and poses.txt as `egomod-log export` does, and points.csv (every point with an
// opinion) for overlays; `fast` leaves points.csv out.
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "egomod/capture/frame_source.hpp"
#include "egomod/core/frame.hpp"
#include "egomod/egomotion/egomotion_estimator.hpp"
#include "egomod/features/feature_tracker.hpp"
#include "egomod/moving_objects/moving_object_detector.hpp"

namespace egomod {
namespace {

void write_pose(std::ostream& out, const Eigen::Isometry3d& T) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      out << (row + column > 0 ? " " : "") << T.matrix()(row, column);
    }
  }
  out << '\n';
}

void write_objects(std::ostream& out, const MovingObjects& objects) {
  for (const MovingObject& o : objects.objects) {
    if (o.state != ObjectState::kMoving || o.points == 0) continue;
    out << objects.sequence << ',' << to_seconds(objects.exposure) << ',' << o.id << ','
        << o.rectangle.u_min_px << ',' << o.rectangle.v_min_px << ',' << o.rectangle.u_max_px << ','
        << o.rectangle.v_max_px << ',' << o.position_m.x() << ',' << o.position_m.y() << ','
        << o.position_m.z() << ',' << o.velocity_mps.x() << ',' << o.velocity_mps.y() << ','
        << o.velocity_mps.z() << ',' << o.points << '\n';
  }
}

void write_points(std::ostream& out, const Frame& frame) {
  std::map<std::uint64_t, const Track*> tracks;
  for (const Track& track : frame.tracks.tracks) tracks[track.id] = &track;
  for (const PointMotion& point : frame.objects.points) {
    const Track& track = *tracks.at(point.track_id);
    out << frame.objects.sequence << ',' << point.track_id << ',' << track.current.u_px << ','
        << track.current.v_px << ',' << point.position_m.z() << ',' << static_cast<int>(point.state)
        << ',' << point.object_id << ',' << point.velocity_mps.x() << ',' << point.velocity_mps.y()
        << ',' << point.velocity_mps.z() << ',' << point.motion_probability << '\n';
  }
}

int run(int argc, char** argv) {
  const std::string output = argv[2];
  std::filesystem::create_directories(output);
  MovingObjectsConfig config;
  if (argc > 3 && std::string(argv[3]) == "thesis") config.method = MovingObjectsMethod::kThesis;
  if (argc > 3 && std::string(argv[3]) == "lag") config.method = MovingObjectsMethod::kLag;
  if (argc > 3 && std::string(argv[3]) == "filter") config.method = MovingObjectsMethod::kFilter;
  CaptureConfig capture;
  if (argc > 4) capture.max_rate_hz = std::stod(argv[4]);
  const bool fast = argc > 5;

  const auto source = open_source("folder:" + std::string(argv[1]), capture, "", "");
  FeatureTracker tracker{FeaturesConfig{}};
  EgomotionEstimator estimator{EgomotionConfig{}};
  MovingObjectDetector detector{config};
  std::ofstream objects(output + "/objects.csv");
  std::ofstream points(output + "/points.csv");
  std::ofstream poses(output + "/poses.txt");
  objects << "frame,time,track_id,u_min,v_min,u_max,v_max,X,Y,Z,VX,VY,VZ,n_points\n";
  points << "frame,track_id,u,v,z,state,object_id,VX,VY,VZ,probability\n";
  for (std::ostream* out : {&objects, &points, &poses}) out->precision(10);

  Frame frame;
  double detection_s = 0.0;
  int pairs = 0;
  for (; source->next(frame.pair, {}) == SourceState::kPair; ++pairs) {
    tracker.track(frame.pair, frame.tracks);
    estimator.estimate(frame.tracks, frame.motion);
    const auto start = std::chrono::steady_clock::now();
    detector.detect(frame.tracks, frame.motion, frame.objects);
    detection_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    write_pose(poses, frame.motion.T_first_current);
    write_objects(objects, frame.objects);
    if (!fast) write_points(points, frame);
  }
  std::printf("%d pairs, moving objects %.3f ms a pair\n", pairs, 1e3 * detection_s / pairs);
  if (!source->error().empty()) std::fprintf(stderr, "%s\n", source->error().c_str());
  return source->error().empty() ? 0 : 1;
}

}  // namespace
}  // namespace egomod

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s SEQUENCE OUTPUT [thesis|lag|filter] [MAX_RATE_HZ] [fast]\n",
                 argv[0]);
    return 2;
  }
  try {
    return egomod::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
