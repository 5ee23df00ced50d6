// SPDX-License-Identifier: Apache-2.0
#include "figure_tables.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "egomod/core/speed_units.hpp"

namespace egomod::eval {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string count(long long value) { return std::to_string(value); }

std::vector<std::string> summary_row(const std::string& name, const std::optional<Summary>& s,
                                     int decimals) {
  if (!s) return {name, "-", "-", "-", "-", "-", "0"};
  return {name,
          number(s->median, decimals),
          number(s->mean, decimals),
          number(s->rmse, decimals),
          number(s->p90, decimals),
          number(s->max, decimals),
          count(static_cast<long long>(s->count))};
}

FigureTable odometry_table(const OdometryFigures& o) {
  FigureTable table{"Odometry", {"figure", "value"}, {}};
  Rows& rows = table.rows;
  rows.push_back({"poses", fmt::format("{} of {}", o.frames, o.truth_frames)});
  rows.push_back({"path, m", number(o.path_m, 2)});
  rows.push_back({"turning, deg", number(o.turn_deg, 1)});
  if (o.drift) {
    rows.push_back({"relative translation drift, %", number(o.drift->translation_percent, 3)});
    rows.push_back({"relative rotation drift, deg/m", number(o.drift->rotation_deg_per_m, 4)});
  } else {
    rows.push_back({"relative drift", "path too short"});
  }
  rows.push_back({"position rmse, first pose aligned, m", number(o.first_aligned_rmse_m, 4)});
  rows.push_back({"position rmse, rigidly aligned, m", number(o.rigid_aligned_rmse_m, 4)});
  rows.push_back({"largest position error, m", number(o.max_error_m, 4)});
  rows.push_back({"end error, m", number(o.end_error_m, 4)});
  rows.push_back({"end error, deg", number(o.end_rotation_deg, 3)});
  return table;
}

FigureTable pair_table(const OdometryFigures& o) {
  return {"Error of each pair's motion",
          {"", "median", "mean", "rmse", "p90", "max", "n"},
          {summary_row("translation, mm", o.pair_mm, 3),
           summary_row("rotation, mdeg", o.pair_mdeg, 3)}};
}

FigureTable segment_table(const RelativeDrift& drift) {
  FigureTable table{
      "Drift by length", {"length, m", "stretches", "translation, %", "rotation, deg/m"}, {}};
  for (const SegmentDrift& s : drift.per_length) {
    table.rows.push_back({number(s.length_m, 2), count(s.segments),
                          number(s.translation_percent, 3), number(s.rotation_deg_per_m, 4)});
  }
  return table;
}

FigureTable detection_table(const DetectionFigures& d) {
  FigureTable table{"Detection", {"figure", "value"}, {}};
  Rows& rows = table.rows;
  rows.push_back({"pairs counted", count(d.frames)});
  rows.push_back({"found (TP)", count(d.tp)});
  rows.push_back({"false (FP)", count(d.fp)});
  rows.push_back({"  of them duplicates", count(d.duplicates)});
  rows.push_back({"  of them on objects at rest", count(d.fp_on_still)});
  rows.push_back({"missed (FN)", count(d.fn)});
  rows.push_back({"not counted: on objects too small, far, slow, new", count(d.ignored)});
  rows.push_back({"precision", number(d.precision, 3)});
  rows.push_back({"recall", number(d.recall, 3)});
  rows.push_back({"F1", number(d.f1, 3)});
  rows.push_back({"false objects a pair", number(d.false_per_pair, 3)});
  rows.push_back({"false objects a minute", number(d.false_per_minute, 2)});
  rows.push_back({"nearest found, m", number(d.min_depth_m, 3)});
  rows.push_back({"farthest found, m", number(d.max_depth_m, 3)});
  rows.push_back({"farthest found beyond the limits, m", number(d.max_depth_any_m, 3)});
  rows.push_back({"identity switches", count(d.switches)});
  rows.push_back({"objects never found", count(d.never_detected)});
  const auto& delay = d.delay_s;
  rows.push_back({"first detection after, mean, s",
                  number(delay ? std::optional(delay->mean) : std::nullopt, 3)});
  rows.push_back({"first detection after, max, s",
                  number(delay ? std::optional(delay->max) : std::nullopt, 3)});
  if (d.velocity_bias_mps) {
    const auto& b = *d.velocity_bias_mps;
    rows.push_back({"velocity bias (right, down, forward), m/s",
                    fmt::format("{:+.3f} {:+.3f} {:+.3f}", b.x(), b.y(), b.z())});
  }
  return table;
}

FigureTable object_error_table(const DetectionFigures& d) {
  return {
      "Errors of found objects",
      {"", "median", "mean", "rmse", "p90", "max", "n"},
      {summary_row("position, m", d.position_m, 3),
       summary_row("position, % of depth", d.position_percent, 2),
       summary_row("  along the depth axis, m", d.position_axial_m, 3),
       summary_row("  lateral, m", d.position_lateral_m, 3),
       summary_row("  to the box's centre, m", d.position_to_centre_m, 3),
       summary_row("velocity, m/s", d.velocity_mps, 3), summary_row("speed, m/s", d.speed_mps, 3)}};
}

FigureTable depth_table(const DetectionFigures& d) {
  FigureTable table{
      "By depth",
      {"depth, m", "due", "recall", "position median, m", "position p90, m", "velocity median, m/s",
       "velocity p90, m/s", "velocity rmse, m/s", "speed median, m/s"},
      {}};
  const auto of = [](const std::optional<Summary>& s, double Summary::*member) {
    return number(s ? std::optional((*s).*member) : std::nullopt, 3);
  };
  for (const DepthFigures& b : d.by_depth) {
    table.rows.push_back({fmt::format("{:g} to {:g}", b.from_m, b.to_m), count(b.due),
                          number(b.recall, 3), of(b.position_m, &Summary::median),
                          of(b.position_m, &Summary::p90), of(b.velocity_mps, &Summary::median),
                          of(b.velocity_mps, &Summary::p90), of(b.velocity_mps, &Summary::rmse),
                          of(b.speed_mps, &Summary::median)});
  }
  return table;
}

FigureTable object_table(const DetectionFigures& d) {
  FigureTable table{
      "Objects", {"object", "class", "due", "recall", "switches", "tracks", "found after, s"}, {}};
  for (const auto& [id, o] : d.objects) {
    const auto recall =
        o.due > 0 ? std::optional(static_cast<double>(o.found) / o.due) : std::nullopt;
    table.rows.push_back({id, o.type, count(o.due), number(recall, 3), count(o.switches),
                          count(o.tracks), number(o.delay_s, 3)});
  }
  return table;
}

std::string with_sigma(double value, const std::optional<double>& sigma, int decimals) {
  return sigma ? fmt::format("{:.{}f} ± {:.{}f}", value, decimals, *sigma, decimals)
               : number(value, decimals);
}

FigureTable speed_table(const SpeedRadar& radar) {
  FigureTable table{"Speed radar, means of the pairs, sigma: standard error of a pair's speed",
                    {"object", "n", "true, m/s", "reported, m/s", "rmse, m/s", "true, km/h",
                     "reported, km/h", "rmse, km/h", "within 1 sigma", "error²/sigma²"},
                    {}};
  const auto add = [&](const std::string& name, const SpeedFigures& s) {
    table.rows.push_back({name, count(static_cast<long long>(s.pairs)), number(s.true_mps, 3),
                          with_sigma(s.mean_mps, s.sigma_mps, 3), number(s.rmse_mps, 3),
                          number(kKmhPerMps * s.true_mps, 2),
                          with_sigma(kKmhPerMps * s.mean_mps, s.sigma_kmh(), 2),
                          number(kKmhPerMps * s.rmse_mps, 2),
                          s.within_sigma ? fmt::format("{:.0f} %", 100.0 * *s.within_sigma) : "-",
                          number(s.error2_by_variance, 2)});
  };
  for (const auto& [id, figures] : radar.objects) add(id, figures);
  add("all", radar.all);
  return table;
}

FigureTable consistency_table(const ConsistencyFigures& c) {
  FigureTable table{"Consistency of covariances (NEES over its degrees of freedom; honest: 1)",
                    {"", "mean", "median", "within 95 %", "n"},
                    {}};
  const auto add = [&](const char* name, const std::optional<Consistency>& of) {
    if (!of) return table.rows.push_back({name, "-", "-", "-", "0"});
    table.rows.push_back({name, number(of->mean_per_dof, 3), number(of->median_per_dof, 3),
                          fmt::format("{:.1f} %", 100.0 * of->within_95),
                          count(static_cast<long long>(of->count))});
  };
  add("motion of a pair", c.pair);
  add("motion over 1 s, by the pose's growth", c.second_by_pose);
  add("motion over 1 s, by the pairs composed", c.second_by_pairs);
  add("pose since the last reset", c.pose);
  add("object velocity", c.object_velocity);
  add("object position", c.object_position);
  return table;
}

FigureTable latency_table(const std::map<std::string, Summary>& latency_ms) {
  FigureTable table{"Latency, ms", {"stage", "median", "mean", "p90", "p99", "max", "n"}, {}};
  for (const auto& [stage, s] : latency_ms) {
    table.rows.push_back({stage, number(s.median, 3), number(s.mean, 3), number(s.p90, 3),
                          number(s.p99, 3), number(s.max, 3),
                          count(static_cast<long long>(s.count))});
  }
  return table;
}

FigureTable noise_table(const std::vector<NoiseFigures>& noise) {
  FigureTable table{"Noise of tracks at rest by depth, sigma in px",
                    {"depth, m", "n", "disparity: learnt", "true, varying", "true, whole",
                     "left position: learnt", "true, varying", "true, whole"},
                    {}};
  for (const NoiseFigures& f : noise) {
    table.rows.push_back(
        {f.to_m > 0.0 ? fmt::format("{:g}-{:g}", f.from_m, f.to_m) : fmt::format("{:g}-", f.from_m),
         count(f.observations), number(f.learnt.disparity_px, 3), number(f.varying.disparity_px, 3),
         number(f.whole.disparity_px, 3), number(f.learnt.pixel_px, 3),
         number(f.varying.pixel_px, 3), number(f.whole.pixel_px, 3)});
  }
  return table;
}

FigureTable point_table(const PointFigures& p) {
  return {"Points that move",
          {"figure", "value"},
          {{"points on movers", count(p.moving)},
           {"points at rest", count(p.still)},
           {"left out (at a mover's edge)", count(p.left_out)},
           {"found (TP)", count(p.tp)},
           {"false (FP)", count(p.fp)},
           {"missed (FN)", count(p.fn)},
           {"precision", number(p.precision, 3)},
           {"recall", number(p.recall, 3)},
           {"F1", number(p.f1, 3)},
           {"false positive rate", number(p.false_positive_rate, 5)},
           {"area under the ROC curve of speed", number(p.area, 4)}}};
}

// What the overview shows of a run.
struct Headline {
  std::string title;
  int decimals;
  std::optional<double> (*of)(const Evaluation& e);
  bool in_method_table = false;
};

template <typename Holder, typename Value>
std::optional<double> from(const Holder& holder, Value value) {
  return holder ? std::optional<double>(value(*holder)) : std::nullopt;
}

std::vector<Headline> headline_columns() {
  using E = const Evaluation&;
  return {
      {"drift, %", 3,
       [](E e) {
         return e.odometry ? from(e.odometry->drift, [](auto& d) { return d.translation_percent; })
                           : std::nullopt;
       },
       true},
      {"deg/m", 4,
       [](E e) {
         return e.odometry ? from(e.odometry->drift, [](auto& d) { return d.rotation_deg_per_m; })
                           : std::nullopt;
       }},
      {"pair, mm", 3,
       [](E e) {
         return e.odometry ? from(e.odometry->pair_mm, [](auto& s) { return s.median; })
                           : std::nullopt;
       }},
      {"ATE, m", 4,
       [](E e) { return from(e.odometry, [](auto& o) { return o.first_aligned_rmse_m; }); }},
      {"NEES 1 s", 2,
       [](E e) {
         return e.consistency
                    ? from(e.consistency->second_by_pose, [](auto& c) { return c.mean_per_dof; })
                    : std::nullopt;
       },
       true},
      {"precision", 3, [](E e) { return e.detection ? e.detection->precision : std::nullopt; },
       true},
      {"recall", 3, [](E e) { return e.detection ? e.detection->recall : std::nullopt; }, true},
      {"F1", 3, [](E e) { return e.detection ? e.detection->f1 : std::nullopt; }, true},
      {"false/min", 2,
       [](E e) { return from(e.detection, [](auto& d) { return d.false_per_minute; }); }, true},
      {"position, m", 3,
       [](E e) {
         return e.detection ? from(e.detection->position_m, [](auto& s) { return s.median; })
                            : std::nullopt;
       }},
      {"velocity rmse, m/s", 3,
       [](E e) {
         return e.detection ? from(e.detection->velocity_mps, [](auto& s) { return s.rmse; })
                            : std::nullopt;
       },
       true},
      {"range, m", 1, [](E e) { return e.detection ? e.detection->max_depth_m : std::nullopt; }},
      {"delay, s", 3,
       [](E e) {
         return e.detection ? from(e.detection->delay_s, [](auto& s) { return s.mean; })
                            : std::nullopt;
       },
       true},
      {"switches", 0,
       [](E e) {
         return from(e.detection, [](auto& d) { return static_cast<double>(d.switches); });
       },
       true},
  };
}

void append_figures(const std::vector<Headline>& columns, const Evaluation& e,
                    std::vector<std::string>& row) {
  for (const Headline& column : columns) row.push_back(number(column.of(e), column.decimals));
}

// Of the runs of one method; the empty one is any.
void append_middle(const std::vector<Headline>& columns, const std::vector<Evaluation>& evaluations,
                   const std::string& method, double Summary::*middle,
                   std::vector<std::string>& row) {
  for (const Headline& column : columns) {
    std::vector<double> known;
    for (const Evaluation& e : evaluations) {
      if (!method.empty() && e.method != method) continue;
      if (const auto value = column.of(e)) known.push_back(*value);
    }
    const auto summary = summarise(known);
    row.push_back(number(summary ? std::optional((*summary).*middle) : std::nullopt,
                         std::max(column.decimals, 1)));
  }
}

}  // namespace

std::string number(const std::optional<double>& value, int decimals) {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "-";
}

std::vector<FigureTable> figure_tables(const Evaluation& e) {
  std::vector<FigureTable> tables;
  if (e.odometry) tables.push_back(odometry_table(*e.odometry));
  if (e.odometry && e.odometry->scored) tables.push_back(pair_table(*e.odometry));
  if (e.odometry && e.odometry->drift) tables.push_back(segment_table(*e.odometry->drift));
  if (e.detection) {
    tables.push_back(detection_table(*e.detection));
    tables.push_back(object_error_table(*e.detection));
    if (!e.detection->by_depth.empty()) tables.push_back(depth_table(*e.detection));
    if (!e.detection->objects.empty()) tables.push_back(object_table(*e.detection));
    if (e.speed_radar) tables.push_back(speed_table(*e.speed_radar));
  }
  if (e.points) tables.push_back(point_table(*e.points));
  if (!e.noise.empty()) tables.push_back(noise_table(e.noise));
  if (e.consistency) tables.push_back(consistency_table(*e.consistency));
  if (!e.latency_ms.empty()) tables.push_back(latency_table(e.latency_ms));
  return tables;
}

FigureTable overview(const std::vector<Evaluation>& evaluations) {
  const std::vector<Headline> columns = headline_columns();
  FigureTable table{"Overview", {"sequence"}, {}};
  for (const Headline& column : columns) table.header.push_back(column.title);
  for (const Evaluation& e : evaluations) {
    table.rows.push_back({e.name});
    append_figures(columns, e, table.rows.back());
  }
  if (evaluations.size() > 1) {
    table.rows.push_back({"mean"});
    append_middle(columns, evaluations, "", &Summary::mean, table.rows.back());
  }
  return table;
}

FigureTable method_table(const std::vector<Evaluation>& evaluations) {
  std::vector<Headline> columns = headline_columns();
  std::erase_if(columns, [](const Headline& column) { return !column.in_method_table; });
  FigureTable table{"", {"world", "method", "s"}, {}};
  for (const Headline& column : columns) table.header.push_back(column.title);
  std::vector<std::string> methods;
  for (const Evaluation& e : evaluations) {
    const double duration_s = e.truth.frames() / e.truth.rate_hz();
    table.rows.push_back({e.name, e.method, number(duration_s, 0)});
    append_figures(columns, e, table.rows.back());
    if (std::find(methods.begin(), methods.end(), e.method) == methods.end())
      methods.push_back(e.method);
  }
  for (const std::string& method : methods) {
    table.rows.push_back({"mean", method, ""});
    append_middle(columns, evaluations, method, &Summary::mean, table.rows.back());
    table.rows.push_back({"median", method, ""});
    append_middle(columns, evaluations, method, &Summary::median, table.rows.back());
  }
  return table;
}

FigureTable headlines(const Evaluation& e) {
  FigureTable table{e.name, {"figure", "value"}, {}};
  for (const Headline& column : headline_columns()) {
    table.rows.push_back({column.title, number(column.of(e), column.decimals)});
  }
  return table;
}

std::string markdown_of(const FigureTable& table) {
  std::string text;
  const auto print = [&](const std::vector<std::string>& row) {
    text += fmt::format("| {} |\n", fmt::join(row, " | "));
  };
  print(table.header);
  std::vector<std::string> rule(table.header.size(), "--:");
  rule.front() = "---";
  print(rule);
  for (const auto& row : table.rows) print(row);
  return text;
}

std::string text_of(const FigureTable& table) {
  const auto width = [](const std::string& utf8) {
    return static_cast<std::size_t>(std::count_if(utf8.begin(), utf8.end(), [](char c) {
      return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
    }));
  };
  std::vector<std::size_t> widths(table.header.size(), 0);
  const auto widen = [&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  };
  widen(table.header);
  for (const auto& row : table.rows) widen(row);
  std::string text = table.title + "\n";
  const auto print = [&](const std::vector<std::string>& row) {
    text += fmt::format("  {:<{}}", row.front(), widths.front());
    for (std::size_t i = 1; i < row.size(); ++i) text += fmt::format("  {:>{}}", row[i], widths[i]);
    text += '\n';
  };
  if (table.header != std::vector<std::string>{"figure", "value"}) print(table.header);
  for (const auto& row : table.rows) print(row);
  return text;
}

}  // namespace egomod::eval
