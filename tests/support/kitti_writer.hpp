// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <span>
#include <string_view>

#include "egomod/core/image.hpp"
#include "synthetic_world.hpp"

namespace egomod::test_support {

// 8-bit grey PNG. Throws std::runtime_error that names the file.
void write_png(const std::filesystem::path& file, const ImageView& image);
// The same with 16 bits.
void write_png16(const std::filesystem::path& file, std::span<const std::uint16_t> pixels,
                 int width_px, int height_px);

// The files of such a folder, piece by piece. Objects that show no pixel get no row; (VX, VY, VZ)
// is the velocity of the box's centre (bx, by, bz), (cx, cy, cz) the centroid of the visible
// surface.
inline constexpr const char* kObjectsHeader =
    "frame,time,object_id,class,cx,cy,cz,bx,by,bz,VX,VY,VZ,wx,wy,wz,"
    "u_min,v_min,u_max,v_max,visible_px,occlusion_fraction,moving\n";
void write_calibration(const StereoCamera& camera, const std::filesystem::path& file);
void write_pose(const Eigen::Isometry3d& T_first_current, std::ostream& out);
void write_object(int frame, double t_s, std::string_view kind, const ObjectTruth& object,
                  std::ostream& out);

struct Recording {
  double rate_hz = 30.0;
  int pairs = 30;
};

// Writes what the world's rig sees from t = 0 on into a folder of the KITTI odometry layout:
// image_0 (left), image_1 (right), calib.txt, times.txt, and the truth as poses.txt and
// objects.csv. Uses every core.
void write_kitti_sequence(const SyntheticWorld& world, const Recording& recording,
                          const std::filesystem::path& folder);

}  // namespace egomod::test_support
