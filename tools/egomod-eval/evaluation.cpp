// SPDX-License-Identifier: Apache-2.0
#include "evaluation.hpp"

#include <algorithm>
#include <string>

#include "record_truth.hpp"
#include "tables.hpp"

namespace egomod::eval {
namespace {

constexpr double kTimeTolerance_s = 1e-3;

// A run at a lower rate than its truth's answers for the pairs that it took.
void keep_processed(const std::vector<int>& processed, Evaluation& e, DetectionOptions& options) {
  options.only = processed;
  std::erase_if(e.estimate.poses, [&](const NumberedPose& pose) {
    return !std::binary_search(processed.begin(), processed.end(), pose.frame);
  });
}

void score_estimate(const Run& run, const DetectionOptions& options, Evaluation& e) {
  if (!e.estimate.poses.empty() && !e.truth.poses.empty())
    e.odometry = score_odometry(e.truth.poses, e.estimate.poses);
  if (e.estimate.detections && e.truth.objects)
    e.detection = score_detection(e.truth, *e.estimate.detections, options);
  if (e.detection) e.speed_radar = score_speeds(e.detection->matches);
  if (!e.odometry && !e.detection) {
    throw InputError(run.estimate + ": holds nothing that " + run.truth + " has the truth of");
  }
  for (const auto& [stage, ms] : e.estimate.stage_ms) {
    if (const auto summary = summarise(ms)) e.latency_ms[stage] = *summary;
  }
}

void score_record(const Record& record, const DetectionOptions& options, Evaluation& e) {
  e.consistency = score_consistency(e.truth, record.poses,
                                    e.detection ? e.detection->matches : std::vector<Match>{});
  if (!record.points) {
    e.notes.push_back("The record holds no EGOMOD_TRACKS (publish.tracks): no figures of points.");
  } else if (e.truth.objects) {
    e.points = score_points(e.truth, *record.points, options.first_frame);
  }
  e.noise = score_noise(e.truth, record, options.first_frame);
  if (e.latency_ms.empty())
    e.notes.push_back("The record holds no EGOMOD_TIMING (--record-timing): no latency.");
}

void note_gaps(const Run& run, Evaluation& e) {
  if (e.truth.poses.empty()) e.notes.push_back("The truth has no poses.txt: odometry not scored.");
  if (e.estimate.poses.empty()) e.notes.push_back("No poses to score.");
  if (e.estimate.detections && !e.truth.objects)
    e.notes.push_back("The truth has no objects.csv: detection not scored.");
  if (e.odometry && !e.odometry->finite)
    e.notes.push_back("Some poses are not finite; they were left out.");
  if (e.odometry && e.odometry->frames < e.odometry->truth_frames && !run.processed_only) {
    e.notes.push_back("Poses for " + std::to_string(e.odometry->frames) + " of " +
                      std::to_string(e.odometry->truth_frames) + " frames.");
  }
  if (e.detection && e.detection->rows_outside > 0) {
    e.notes.push_back(std::to_string(e.detection->rows_outside) +
                      " objects lie behind the end of the sequence: is this its truth?");
  }
  if (e.detection && e.detection->time_mismatch_s.value_or(0.0) > kTimeTolerance_s) {
    e.notes.push_back("Times of objects differ from times.txt by up to " +
                      std::to_string(*e.detection->time_mismatch_s) + " s: frames shifted?");
  }
}

}  // namespace

Evaluation evaluate(const Run& run, DetectionOptions options) {
  Evaluation e;
  e.method = run.method;
  e.truth = run.truth.empty() ? read_truth_of_record(run.estimate) : read_truth(run.truth);
  e.name = run.name.empty() ? e.truth.name : run.name;
  e.source = run.estimate;
  if (run.kind == EstimateKind::kRecord) {
    const Record record = read_record(run.estimate);
    e.estimate = record.estimate;
    if (run.processed_only) keep_processed(record.processed, e, options);
    score_estimate(run, options, e);
    score_record(record, options, e);
  } else {
    e.estimate = run.kind == EstimateKind::kResult
                     ? read_result(run.estimate)
                     : Estimate{.poses = read_poses(run.estimate, run.format, e.truth.times_s),
                                .detections = std::nullopt,
                                .stage_ms = {}};
    score_estimate(run, options, e);
  }
  note_gaps(run, e);
  return e;
}

}  // namespace egomod::eval
