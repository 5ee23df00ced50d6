// SPDX-License-Identifier: Apache-2.0
#include "record_labels.hpp"

#include <optional>

#include "point_truth.hpp"
#include "track_record.hpp"

namespace egomod::fit {
namespace {

// Nothing where the choice leaves the point out; `truth` is there unless RANSAC alone decides.
std::optional<bool> label_of(const track_t& track, const eval::PointEvidence& point,
                             PointChoice choice, std::optional<eval::PointTruth>& truth) {
  const bool inlier = track.role == track_t::ROLE_INLIER;
  const bool outlier = track.role == track_t::ROLE_OUTLIER;
  if (choice != PointChoice::kAll && !inlier && !outlier) return std::nullopt;
  if (!truth) return outlier;
  const auto moving = truth->moves(point);
  if (choice == PointChoice::kRansac && moving && *moving != outlier) return std::nullopt;
  return moving;
}

}  // namespace

eval::Truth read_object_truth(const std::string& folder) {
  eval::Truth truth = eval::read_truth(folder);
  if (!truth.objects) throw InputError(folder + ": has no objects.csv, which tells what moves");
  return truth;
}

RecordLabels label_record(const std::string& log, const std::string& truth_directory,
                          PointChoice choice) {
  std::optional<eval::Truth> objects;
  std::optional<eval::PointTruth> truth;
  if (choice != PointChoice::kRoles) {
    objects = read_object_truth(truth_directory);
    truth.emplace(*objects);
  }
  RecordLabels result;
  result.damage = for_each_tracked_pair(log, [&](const TrackedPair& pair) {
    for (const track_t& track : pair.list.tracks) {
      if (track.state == track_t::STATE_UNKNOWN || !(track.disparity > 0.0F)) continue;
      const eval::PointEvidence point = pair.point(track);
      const auto moving = label_of(track, point, choice, truth);
      if (!moving) continue;
      (*moving ? result.labels.moving_mps : result.labels.static_mps).push_back(point.speed_mps);
    }
  });
  return result;
}

}  // namespace egomod::fit
