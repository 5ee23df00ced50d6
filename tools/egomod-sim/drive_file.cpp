// SPDX-License-Identifier: Apache-2.0
#include "drive_file.hpp"

#include <fmt/format.h>

#include "camera_tables.hpp"

namespace egomod::sim {
namespace {

constexpr double kFar_m = 1000.0;

double degrees(TableReader& in, const std::string& key, double fallback_rad, double max_deg) {
  return in.number(key, fallback_rad / kRadPerDeg, 0.0, max_deg) * kRadPerDeg;
}

DriveCommand read_command(TableReader& in) {
  DriveCommand command;
  command.from_s = in.number("at_s", std::nullopt, 0.0, 1e5);
  command.linear_mps = in.number("speed_mps", 0.0, -50.0, 50.0);
  command.angular_radps = -in.number("turn_degps", 0.0, -720.0, 720.0) * kRadPerDeg;
  return command;
}

}  // namespace

Drive read_drive(TableReader& in, const Floor& floor) {
  Drive drive;
  const auto at = in.numbers("position_m", 2, -kFar_m, kFar_m);
  drive.start = {at[0], at[1], in.number("heading_deg", 0.0, -360.0, 360.0) * kRadPerDeg};
  drive.max_speed_mps = in.number("max_speed_mps", drive.max_speed_mps, 0.0, 50.0);
  drive.max_turn_radps = degrees(in, "max_turn_degps", drive.max_turn_radps, 720.0);
  drive.acceleration_mps2 = in.number("acceleration_mps2", drive.acceleration_mps2, 0.001, 100.0);
  drive.turn_acceleration_radps2 =
      degrees(in, "turn_acceleration_degps2", drive.turn_acceleration_radps2, 1e4);
  drive.lag_s = in.number("lag_s", drive.lag_s, 0.0, 10.0);
  drive.watchdog_s = in.number("watchdog_s", drive.watchdog_s, 0.01, 100.0);
  drive.odometry_rate_hz = in.number("odometry_rate_hz", drive.odometry_rate_hz, 1.0, 100.0);
  drive.wheel_slip = in.number("wheel_slip", drive.wheel_slip, 0.0, 0.9);
  drive.wheel_noise_m_per_sqrt_m =
      in.number("wheel_noise_m_per_sqrt_m", drive.wheel_noise_m_per_sqrt_m, 0.0, 1.0);
  const double r = drive.radius_m;
  if (at[0] < floor.x_min_m + r || at[0] > floor.x_max_m - r || at[1] < floor.z_min_m + r ||
      at[1] > floor.z_max_m - r) {
    in.fail("position_m", fmt::format("is outside the world, or nearer to a wall than {} m", r));
  }
  in.tables("command", [&](TableReader& table) {
    const DriveCommand command = read_command(table);
    if (!drive.script.empty() && command.from_s <= drive.script.back().from_s) {
      table.fail("at_s", "commands must be in the order of their times");
    }
    drive.script.push_back(command);
  });
  return drive;
}

}  // namespace egomod::sim
