// SPDX-License-Identifier: Apache-2.0
#include "track_record.hpp"

#include <cmath>
#include <egomod/calibration_t.hpp>
#include <egomod/pose_t.hpp>
#include <egomod/velocity_t.hpp>
#include <optional>

#include "labels.hpp"
#include "log_reader.hpp"

namespace egomod::fit {

eval::PointEvidence TrackedPair::point(const track_t& track) const {
  return {.frame = static_cast<int>(list.sequence),
          .u_px = track.u,
          .v_px = track.v,
          .depth_m = depth_times_disparity / static_cast<double>(track.disparity),
          .speed_mps = std::hypot(track.vel[0], track.vel[1], track.vel[2]),
          .moving = track.state == track_t::STATE_MOVING,
          .track = track.id,
          .disparity_px = track.disparity};
}

std::string for_each_tracked_pair(const std::string& log,
                                  const std::function<void(const TrackedPair&)>& use) {
  log::LogReader reader(log);
  std::optional<calibration_t> calibration;
  velocity_t velocity{};
  TrackedPair pair;
  bool has_tracks = false;
  while (const lcm::LogEvent* event = reader.next()) {
    if (event->channel == "EGOMOD_CALIBRATION") {
      reader.decode(*event, calibration.emplace());
      pair.depth_times_disparity = calibration->fx * calibration->baseline;
    } else if (event->channel == "EGOMOD_VELOCITY") {
      reader.decode(*event, velocity);
      if (velocity.status == pose_t::STATUS_VALID)
        pair.rig_speed_mps = std::hypot(velocity.vel[0], velocity.vel[1], velocity.vel[2]);
    } else if (event->channel == "EGOMOD_TRACKS" && calibration) {
      reader.decode(*event, pair.list);
      has_tracks = true;
      use(pair);
    }
  }
  if (!has_tracks && !reader.damage().empty()) throw InputError(reader.damage());
  if (!calibration) throw InputError(log + ": has no EGOMOD_CALIBRATION; is it a record?");
  if (!has_tracks) {
    throw InputError(log + ": has no EGOMOD_TRACKS; record with publish.tracks = true");
  }
  return reader.damage();
}

}  // namespace egomod::fit
