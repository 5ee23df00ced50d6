// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driven_base.hpp"
#include "egomod/core/calibration.hpp"
#include "motion.hpp"
#include "optics.hpp"

namespace egomod::sim {

// What separates a photograph from a rendering. Grey levels of 255; noise and exposure resemble by
// default the colour camera of a Kinect v1 indoors, while the lens is sharp and the shutter global.
struct Realism {
  double softness_px = 0.0;  // standard deviation of a point's picture: lens, colour filter
  double read_noise = 1.0;   // standard deviation in the dark
  double shot_noise = 0.13;  // times the root of the grey value, in quadrature
  double vignetting = 0.12;  // share of the light that the corners lose
  double right_gain = 1.02;  // the right camera's exposure by the left one's
  double gain_drift = 0.01;  // both exposures wander by this share
  double gain_drift_period_s = 8.0;
  double exposure_s = 0.0;  // motion blur
  int blur_samples = 1;     // renderings an exposure; 1: no blur
  double readout_s = 0.0;   // of all rows by a rolling shutter; 0: all at once
  int readout_strips = 60;  // rows of one strip are rendered at one instant
};

// When the cameras expose, and what of it arrives. By default both at the same time, each image
// at once.
struct Timing {
  double jitter_s = 0.0;          // standard deviation of an exposure from its regular time
  double right_offset_s = 0.0;    // of the right camera's first exposure
  double right_drift_ppm = 0.0;   // by which its frame interval is longer
  double drop_probability = 0.0;  // of each image
  double late_probability = 0.0;  // of each image
  double late_s = 0.0;            // by which it then arrives late

  // The right camera has a clock of its own.
  [[nodiscard]] bool runs_free() const { return right_offset_s != 0.0 || right_drift_ppm != 0.0; }
  // Images come as pairs of one instant, none missing.
  [[nodiscard]] bool is_paired() const { return !runs_free() && drop_probability == 0.0; }
  // And arrive so: one message can hold both.
  [[nodiscard]] bool comes_in_pairs() const { return is_paired() && late_probability == 0.0; }
};

// Uneven floor: a function of the way, so that a resting rig rests. Peak values.
struct Wobble {
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
  double bounce_m = 0.0;
  double wavelength_m = 0.35;
};

struct Rig {
  Motion motion;
  std::optional<Drive> driven;  // then it follows commands instead
  double height_m = 0.45;
  double pitch_rad = 0.0;  // positive looks down
  Wobble wobble;
};

// Floor from x = -width / 2 to width / 2 and z = -rear to length - rear, at height 0.
enum class ShellKind { kRoom, kCorridor, kStreet };
struct Shell {
  ShellKind kind = ShellKind::kRoom;
  double width_m = 7.0;
  double length_m = 12.0;
  double height_m = 2.8;
  double rear_m = 1.0;
  std::string left = "wall";
  std::string right = "wall";
  std::string front = "bricks";
  std::string back = "bricks";
  std::string floor = "tiles";
  std::string ceiling = "whitewash";
};

enum class Wall { kLeft, kRight, kFront, kBack };
struct Poster {
  Wall wall = Wall::kFront;
  double along_m = 0.0;   // its middle: z on left and right, x on front and back
  double height_m = 1.5;  // of its middle
  Eigen::Vector2d size_m{0.9, 1.2};
};

enum class ThingKind { kBox, kPioneer, kPerson, kCar };
struct Thing {
  ThingKind kind = ThingKind::kBox;
  int id = 0;  // 0: furniture, which is no object
  Motion motion;
  Eigen::Vector3d size_m{0.6, 0.6, 0.6};  // across, high, along; boxes only
  double lift_m = 0.0;                    // above the floor; boxes only
  std::string material = "carton";        // boxes only
};

struct World {
  std::string name;
  double duration_s = 10.0;  // 0: endless
  double rate_hz = 30.0;
  std::uint32_t seed = 1;
  StereoCamera camera;  // rectified; all truth is in its left one's frame
  Optics optics;
  Realism realism;
  Timing timing;
  Rig rig;
  Shell shell;
  std::vector<Poster> posters;
  std::vector<Thing> things;

  [[nodiscard]] bool is_endless() const { return duration_s == 0.0; }
  [[nodiscard]] int pairs() const;  // at 0, 1 / rate, ... up to and without duration
};

[[nodiscard]] Floor floor_of(const Shell& shell);
[[nodiscard]] std::string to_string(ThingKind kind);
// Of the box around the thing at rest.
[[nodiscard]] Eigen::Vector3d size_m(const Thing& thing);

}  // namespace egomod::sim
