// SPDX-License-Identifier: Apache-2.0
#include "record_labels.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <egomod/calibration_t.hpp>
#include <egomod/track_list_t.hpp>
#include <map>
#include <optional>

#include "log_reader.hpp"

namespace egomod::fit {
namespace {

// Stereo places a point at 10 m to about this share of its depth.
constexpr double kDepthSlackShare = 0.05;
constexpr double kDepthSlack_m = 0.15;

struct TruthObject {
  double u_min_px, v_min_px, u_max_px, v_max_px;
  double near_m, far_m;
  bool moving;

  [[nodiscard]] bool contains(double u_px, double v_px) const {
    return u_px >= u_min_px && u_px <= u_max_px && v_px >= v_min_px && v_px <= v_max_px;
  }
};
using Truth = std::map<std::int64_t, std::vector<TruthObject>>;  // by pair

// An object reaches as far behind its centre (b) as its visible surface (c) lies before it.
Truth read_truth(const std::string& path) {
  const Table table(path);
  const std::size_t frame = table.column("frame");
  const std::size_t c = table.column("cz");
  const std::size_t b = table.column("bz");
  const std::size_t u_min = table.column("u_min");
  const std::size_t v_min = table.column("v_min");
  const std::size_t u_max = table.column("u_max");
  const std::size_t v_max = table.column("v_max");
  const std::size_t moving = table.column("moving");
  Truth truth;
  for (const Table::Row& row : table.rows()) {
    const double surface_m = table.number(row, c);
    const double centre_m = table.number(row, b);
    const double reach_m = std::abs(centre_m - surface_m);
    const double slack_m = kDepthSlack_m + kDepthSlackShare * surface_m;
    truth[std::llround(table.number(row, frame))].push_back(
        {table.number(row, u_min), table.number(row, v_min), table.number(row, u_max),
         table.number(row, v_max), surface_m - reach_m - slack_m, centre_m + reach_m + slack_m,
         table.flag(row, moving)});
  }
  return truth;
}

// 0 or 1; nothing when the truth leaves it open.
std::optional<bool> moves(const std::vector<TruthObject>& objects, double u_px, double v_px,
                          double depth_m) {
  bool inside = false;
  for (const TruthObject& object : objects) {
    if (!object.contains(u_px, v_px)) continue;
    inside = true;
    if (object.moving && depth_m >= object.near_m && depth_m <= object.far_m) return true;
  }
  return inside ? std::nullopt : std::optional<bool>(false);
}

// 0 or 1; nothing where the choice leaves the point out.
std::optional<bool> label_of(const track_t& track, double depth_m,
                             const std::vector<TruthObject>& objects, PointChoice choice) {
  const bool inlier = track.role == track_t::ROLE_INLIER;
  const bool outlier = track.role == track_t::ROLE_OUTLIER;
  if (choice != PointChoice::kAll && !inlier && !outlier) return std::nullopt;
  if (choice == PointChoice::kRoles) return outlier;
  const auto moving = moves(objects, track.u, track.v, depth_m);
  if (choice == PointChoice::kRansac && moving && *moving != outlier) return std::nullopt;
  return moving;
}

void label_tracks(const track_list_t& list, const calibration_t& calibration,
                  const std::vector<TruthObject>& objects, PointChoice choice, Labels& labels) {
  for (const track_t& track : list.tracks) {
    if (track.state == track_t::STATE_UNKNOWN || !(track.disparity > 0.0F)) continue;
    const double depth_m =
        calibration.fx * calibration.baseline / static_cast<double>(track.disparity);
    const auto moving = label_of(track, depth_m, objects, choice);
    if (!moving) continue;
    const double speed_mps = std::hypot(track.vel[0], track.vel[1], track.vel[2]);
    (*moving ? labels.moving_mps : labels.static_mps).push_back(speed_mps);
  }
}

}  // namespace

RecordLabels label_record(const std::string& log, const std::string& truth_directory,
                          PointChoice choice) {
  const Truth truth =
      choice == PointChoice::kRoles ? Truth{} : read_truth(truth_directory + "/objects.csv");
  log::LogReader reader(log);
  RecordLabels result;
  std::optional<calibration_t> calibration;
  track_list_t list;
  bool has_tracks = false;
  while (const lcm::LogEvent* event = reader.next()) {
    if (event->channel == "EGOMOD_CALIBRATION") reader.decode(*event, calibration.emplace());
    if (event->channel != "EGOMOD_TRACKS" || !calibration) continue;
    reader.decode(*event, list);
    has_tracks = true;
    const auto at = truth.find(list.sequence);
    label_tracks(list, *calibration, at == truth.end() ? std::vector<TruthObject>{} : at->second,
                 choice, result.labels);
  }
  result.damage = reader.damage();
  if (!has_tracks && !result.damage.empty()) throw InputError(result.damage);
  if (!calibration) throw InputError(log + ": has no EGOMOD_CALIBRATION; is it a record?");
  if (!has_tracks) {
    throw InputError(log + ": has no EGOMOD_TRACKS; record with publish.tracks = true");
  }
  return result;
}

}  // namespace egomod::fit
