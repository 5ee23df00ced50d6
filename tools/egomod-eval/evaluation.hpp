// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "consistency.hpp"
#include "detection.hpp"
#include "noise.hpp"
#include "odometry.hpp"
#include "points.hpp"
#include "record.hpp"
#include "sequence.hpp"
#include "speed_radar.hpp"

namespace egomod::eval {

enum class EstimateKind { kRecord, kResult, kPoses };

struct Run {
  std::string name;   // empty: the truth's
  std::string truth;  // empty: what a record of the built-in world holds itself
  std::string estimate;
  EstimateKind kind = EstimateKind::kRecord;
  PoseFormat format = PoseFormat::kKitti;
  std::string method;           // a label, for tables of several runs
  bool processed_only = false;  // count only the pairs that a record has a list of objects of
};

struct Evaluation {
  std::string name;
  std::string source;  // what was evaluated
  std::string method;
  Truth truth;
  Estimate estimate;
  std::optional<OdometryFigures> odometry;
  std::optional<DetectionFigures> detection;
  std::optional<SpeedRadar> speed_radar;
  std::optional<ConsistencyFigures> consistency;
  std::optional<PointFigures> points;
  std::vector<NoiseFigures> noise;  // by depth
  std::map<std::string, Summary> latency_ms;
  std::vector<std::string> notes;  // what could not be evaluated, and why; what looks wrong
};

// Throws an exception that names file and place.
[[nodiscard]] Evaluation evaluate(const Run& run, DetectionOptions options);

}  // namespace egomod::eval
