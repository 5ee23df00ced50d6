// SPDX-License-Identifier: Apache-2.0
#include "json.hpp"

#include <fmt/format.h>

#include <cmath>

#include "egomod/core/speed_units.hpp"

namespace egomod::eval {
namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<int>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string value_of(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "null";
}
std::string value_of(int value) { return std::to_string(value); }
std::string value_of(bool value) { return value ? "true" : "false"; }
std::string value_of(const std::string& value) { return quoted(value); }

std::string array_of(const std::vector<std::string>& values) {
  return fmt::format("[{}]", fmt::join(values, ", "));
}

// Members in the order in which they are added.
class Object {
 public:
  template <typename Value>
  Object& add(const char* key, const Value& value) {
    return add_json(key, value_of(value));
  }
  template <typename Value>
  Object& add(const char* key, const std::optional<Value>& value) {
    return add_json(key, value ? value_of(*value) : "null");
  }
  Object& add_json(const std::string& key, const std::string& json) {
    members_.push_back(quoted(key) + ": " + json);
    return *this;
  }
  [[nodiscard]] std::string text() const {
    return fmt::format("{{{}}}", fmt::join(members_, ", "));
  }

 private:
  std::vector<std::string> members_;
};

std::string of(const std::optional<Summary>& s) {
  if (!s) return "null";
  return Object()
      .add("median", s->median)
      .add("mean", s->mean)
      .add("rmse", s->rmse)
      .add("p90", s->p90)
      .add("p99", s->p99)
      .add("max", s->max)
      .add("n", static_cast<int>(s->count))
      .text();
}

std::string of(const std::optional<Consistency>& c) {
  if (!c) return "null";
  return Object()
      .add("mean_per_dof", c->mean_per_dof)
      .add("median_per_dof", c->median_per_dof)
      .add("within_95", c->within_95)
      .add("dof", c->dof)
      .add("n", static_cast<int>(c->count))
      .text();
}

std::string of(const RelativeDrift& drift) {
  std::vector<std::string> lengths;
  for (const SegmentDrift& s : drift.per_length) {
    lengths.push_back(Object()
                          .add("length_m", s.length_m)
                          .add("segments", s.segments)
                          .add("t_percent", s.translation_percent)
                          .add("r_deg_per_m", s.rotation_deg_per_m)
                          .text());
  }
  return Object()
      .add("t_percent", drift.translation_percent)
      .add("r_deg_per_m", drift.rotation_deg_per_m)
      .add_json("per_length", array_of(lengths))
      .text();
}

std::string of(const OdometryFigures& o) {
  Object json;
  json.add("gt_frames", o.truth_frames).add("est_frames", o.frames).add("finite", o.finite);
  if (!o.scored) return json.text();
  const std::string ate = Object()
                              .add("first_frame_aligned_rmse", o.first_aligned_rmse_m)
                              .add("rigid_aligned_rmse", o.rigid_aligned_rmse_m)
                              .add("end_error", o.end_error_m)
                              .add("max", o.max_error_m)
                              .text();
  return json.add_json("rpe_mm", of(o.pair_mm))
      .add_json("rpe_mdeg", of(o.pair_mdeg))
      .add("path_m", o.path_m)
      .add("turn_deg", o.turn_deg)
      .add_json("ate_m", ate)
      .add("end_rotation_deg", o.end_rotation_deg)
      .add_json("kitti", o.drift ? of(*o.drift) : "null")
      .text();
}

std::string depths_of(const DetectionFigures& d) {
  std::vector<std::string> depths;
  for (const DepthFigures& b : d.by_depth) {
    depths.push_back(Object()
                         .add("from_m", b.from_m)
                         .add("to_m", b.to_m)
                         .add("gt", b.due)
                         .add("recall", b.recall)
                         .add_json("position_m", of(b.position_m))
                         .add_json("velocity_m_s", of(b.velocity_mps))
                         .add_json("speed_m_s", of(b.speed_mps))
                         .text());
  }
  return array_of(depths);
}

std::string objects_of(const DetectionFigures& d) {
  Object objects;
  for (const auto& [id, o] : d.objects) {
    const auto recall =
        o.due > 0 ? std::optional(static_cast<double>(o.found) / o.due) : std::nullopt;
    objects.add_json(id, Object()
                             .add("class", o.type)
                             .add("eligible_frames", o.due)
                             .add("recall", recall)
                             .add("id_switches", o.switches)
                             .add("tracks", o.tracks)
                             .add("first_detection_delay_s", o.delay_s)
                             .text());
  }
  return objects.text();
}

std::string bias_of(const DetectionFigures& d) {
  if (!d.velocity_bias_mps) return "null";
  const Eigen::Vector3d& b = *d.velocity_bias_mps;
  return array_of({value_of(b.x()), value_of(b.y()), value_of(b.z())});
}

std::string of(const DetectionFigures& d) {
  Object json;
  json.add("frames", d.frames).add("duration_s", d.duration_s);
  json.add("rows_outside_sequence", d.rows_outside).add("time_mismatch_s", d.time_mismatch_s);
  json.add("tp", d.tp).add("fp", d.fp).add("fn", d.fn);
  json.add("precision", d.precision).add("recall", d.recall).add("f1", d.f1);
  json.add("fp_per_frame", d.false_per_pair).add("fp_per_minute", d.false_per_minute);
  json.add("fp_duplicates", d.duplicates).add("fp_on_still_objects", d.fp_on_still);
  json.add("ignored_on_other_objects", d.ignored);
  json.add_json("position_m", of(d.position_m));
  json.add_json("position_percent_of_depth", of(d.position_percent));
  json.add_json("position_depth_axis_m", of(d.position_axial_m));
  json.add_json("position_lateral_m", of(d.position_lateral_m));
  json.add_json("position_vs_box_centre_m", of(d.position_to_centre_m));
  json.add_json("velocity_m_s", of(d.velocity_mps)).add_json("speed_m_s", of(d.speed_mps));
  json.add_json("velocity_bias_m_s", bias_of(d));
  json.add("min_depth_m", d.min_depth_m).add("max_depth_m", d.max_depth_m);
  json.add("max_depth_any_m", d.max_depth_any_m);
  json.add_json("by_depth", depths_of(d)).add_json("objects", objects_of(d));
  json.add("id_switches", d.switches).add("objects_never_detected", d.never_detected);
  json.add_json("first_detection_delay_s", of(d.delay_s));
  return json.text();
}

std::string of(const SpeedFigures& s) {
  Object json;
  json.add("n", static_cast<int>(s.pairs)).add("true_m_s", s.true_mps);
  json.add("true_km_h", kKmhPerMps * s.true_mps);
  json.add("speed_m_s", s.mean_mps).add("sigma_m_s", s.sigma_mps);
  json.add("speed_km_h", kKmhPerMps * s.mean_mps).add("sigma_km_h", s.sigma_kmh());
  json.add("rmse_m_s", s.rmse_mps).add("rmse_km_h", kKmhPerMps * s.rmse_mps);
  json.add("within_sigma", s.within_sigma).add("mean_error2_by_variance", s.error2_by_variance);
  return json.text();
}

std::string of(const SpeedRadar& radar) {
  Object objects;
  for (const auto& [id, figures] : radar.objects) objects.add_json(id, of(figures));
  return Object().add_json("all", of(radar.all)).add_json("objects", objects.text()).text();
}

std::string of(const PointFigures& p) {
  Object json;
  json.add("moving", p.moving).add("still", p.still).add("left_out", p.left_out);
  json.add("tp", p.tp).add("fp", p.fp).add("fn", p.fn);
  json.add("precision", p.precision).add("recall", p.recall).add("f1", p.f1);
  json.add("false_positive_rate", p.false_positive_rate).add("roc_area", p.area);
  return json.text();
}

std::string of(const NoisePair& pair) {
  return Object().add("left_position", pair.pixel_px).add("disparity", pair.disparity_px).text();
}

std::string of(const NoiseFigures& f) {
  Object json;
  json.add("from_m", f.from_m).add("to_m", f.to_m).add("observations", f.observations);
  json.add_json("learnt_px", of(f.learnt)).add_json("true_varying_px", of(f.varying));
  return json.add_json("true_whole_px", of(f.whole)).text();
}

std::string of(const ConsistencyFigures& c) {
  return Object()
      .add_json("pair", of(c.pair))
      .add_json("second_by_pose_growth", of(c.second_by_pose))
      .add_json("second_by_pairs_composed", of(c.second_by_pairs))
      .add_json("pose", of(c.pose))
      .add_json("object_velocity", of(c.object_velocity))
      .add_json("object_position", of(c.object_position))
      .text();
}

std::string of(const Evaluation& e) {
  Object json;
  json.add("sequence", e.name).add("source", e.source).add("frames", e.truth.frames());
  if (!e.method.empty()) json.add("method", e.method);
  if (e.odometry) json.add_json("odometry", of(*e.odometry));
  if (e.detection) json.add_json("detection", of(*e.detection));
  if (e.speed_radar) json.add_json("speed_radar", of(*e.speed_radar));
  if (e.points) json.add_json("points", of(*e.points));
  std::vector<std::string> noise;
  for (const NoiseFigures& figures : e.noise) noise.push_back(of(figures));
  if (!noise.empty()) json.add_json("noise", array_of(noise));
  if (e.consistency) json.add_json("nees", of(*e.consistency));
  Object latency;
  for (const auto& [stage, summary] : e.latency_ms)
    latency.add_json(stage, of(std::optional(summary)));
  if (!e.latency_ms.empty()) json.add_json("latency_ms", latency.text());
  std::vector<std::string> notes;
  for (const std::string& note : e.notes) notes.push_back(quoted(note));
  return json.add_json("notes", array_of(notes)).text();
}

}  // namespace

std::string json_of(const std::vector<Evaluation>& evaluations) {
  if (evaluations.size() == 1) return of(evaluations.front()) + "\n";
  std::vector<std::string> all;
  all.reserve(evaluations.size());
  for (const Evaluation& e : evaluations) all.push_back(of(e));
  return fmt::format("[{}]\n", fmt::join(all, ",\n"));
}

}  // namespace egomod::eval
