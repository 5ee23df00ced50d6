// SPDX-License-Identifier: Apache-2.0
#include "plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "egomod/core/speed_units.hpp"

namespace egomod::eval {
namespace {

constexpr std::size_t kMostObjects = 8;
constexpr std::array<const char*, kMostObjects> kColours{
    "#1f6feb", "#d1570b", "#2a8a4a", "#8250df", "#b3261e", "#0f7f8c", "#9a6700", "#57606a"};

struct Range {
  double low = 0.0, high = 0.0;
  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double centre() const { return 0.5 * (low + high); }
  [[nodiscard]] double length() const { return high - low; }
};

// From above, forwards to the right; a metre is as long on both axes.
Figure trajectory(const AlignedPoses& poses) {
  FigureData data("path");
  Range forward;
  Range left;
  for (std::size_t i = 0; i < poses.truth.size(); ++i) {
    const Eigen::Vector3d t = poses.truth[i].translation();
    const Eigen::Vector3d e = poses.estimate[i].translation();
    data.row(t.z(), -t.x(), e.z(), -e.x());
    for (const Eigen::Vector3d& p : {t, e}) {
      forward.take(p.z());
      left.take(-p.x());
    }
  }
  constexpr double kBoxWidth_px = kFigureWidth_px - 100.0;
  constexpr double kBoxHeight_px = kFigureHeight_px - 75.0;
  const double metres_per_px =
      std::max({1.1 * forward.length() / kBoxWidth_px, 1.2 * left.length() / kBoxHeight_px, 1e-9});
  const auto range = [&](const char* axis, const Range& r, double box_px) {
    return fmt::format("set {}range [{:.9g}:{:.9g}]\n", axis,
                       r.centre() - 0.5 * box_px * metres_per_px,
                       r.centre() + 0.5 * box_px * metres_per_px);
  };
  return {"Trajectory from above",
          data.text() + "set lmargin 9\nset rmargin 2\n" + range("x", forward, kBoxWidth_px) +
              range("y", left, kBoxHeight_px) +
              "set xlabel 'forward [m]'\nset ylabel 'left [m]'\n"
              "plot $path using 1:2 with lines lw 5 lc rgb '#c8ccd1' title 'truth', "
              "$path using 3:4 with lines lw 1.6 lc rgb '#1f6feb' title 'estimate'\n"};
}

Figure pose_error(const AlignedPoses& poses, const std::vector<double>& times_s) {
  FigureData data("error");
  for (std::size_t i = 0; i < poses.truth.size(); ++i) {
    const auto frame = static_cast<std::size_t>(poses.frames[i]);
    if (frame >= times_s.size()) break;
    const Eigen::Isometry3d error = poses.truth[i].inverse() * poses.estimate[i];
    data.row(times_s[frame], 1e3 * error.translation().norm(), angle_deg(error));
  }
  return {"Pose error over time, first pose aligned",
          data.text() +
              "set xlabel 'time [s]'\nset ylabel 'position [mm]' textcolor rgb '#1f6feb'\n"
              "set y2label 'rotation [deg]' textcolor rgb '#d1570b'\n"
              "set y2tics\nset ytics nomirror\nset yrange [0:*]\nset y2range [0:*]\n"
              "plot $error using 1:2 with lines lw 2 lc rgb '#1f6feb' title 'position', "
              "$error using 1:3 axes x1y2 with lines lw 2 lc rgb '#d1570b' title 'rotation'\n"};
}

// The objects that were found most often.
std::vector<std::string> shown_objects(const DetectionFigures& detection) {
  std::map<std::string, int> found;
  for (const Match& m : detection.matches) ++found[m.truth.id];
  std::vector<std::string> ids;
  ids.reserve(found.size());
  for (const auto& [id, times] : found) ids.push_back(id);
  std::stable_sort(ids.begin(), ids.end(),
                   [&](const std::string& a, const std::string& b) { return found[a] > found[b]; });
  ids.resize(std::min(ids.size(), kMostObjects));
  return ids;
}

std::string truth_speed(const Truth& truth, const std::string& id, const std::string& name) {
  FigureData data(name);
  double last_s = 0.0;
  const double most_s = 1.5 / truth.rate_hz();
  for (const auto& [frame, objects] : *truth.objects) {
    for (const TruthObject& object : objects) {
      if (object.id != id || object.visible_px <= 0) continue;
      if (!data.empty() && object.time_s - last_s > most_s) data.gap();
      last_s = object.time_s;
      data.row(object.time_s, object.velocity_mps.norm());
    }
  }
  return data.text();
}

std::optional<Figure> speeds(const Evaluation& e) {
  const std::vector<std::string> ids = shown_objects(*e.detection);
  if (ids.empty()) return std::nullopt;
  std::string blocks;
  std::string plots;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    FigureData found("found" + std::to_string(k));
    for (const Match& m : e.detection->matches) {
      if (m.truth.id == ids[k] && m.estimate.velocity_mps.allFinite())
        found.row(m.truth.time_s, m.estimate.velocity_mps.norm(),
                  m.estimate.speed_sigma_mps.value_or(0.0));
    }
    if (found.empty()) continue;
    blocks += truth_speed(e.truth, ids[k], "truth" + std::to_string(k)) + found.text();
    plots += fmt::format(
        "{}$truth{} with lines lw 5 lc rgb '#b0{}' title 'object {}, truth', "
        "$found{} with yerrorbars pt 7 ps 0.45 lw 0.5 lc rgb '{}' title 'estimate'",
        plots.empty() ? "" : ", ", k, std::string(kColours[k]).substr(1), quotable(ids[k]), k,
        kColours[k]);
  }
  if (plots.empty()) return std::nullopt;
  return Figure{"Speed of objects over time, with standard errors",
                blocks + "set xlabel 'time [s]'\nset ylabel 'speed [m/s]'\nset yrange [0:*]\n" +
                    fmt::format("set link y2 via {0}*y inverse y/{0}\n", kKmhPerMps) +
                    "set y2label 'speed [km/h]'\nset y2tics\nset ytics nomirror\n"
                    "set key maxrows 4\nplot " +
                    plots + "\n"};
}

template <typename Error>
std::optional<Figure> by_depth(const DetectionFigures& detection, const char* caption,
                               const char* label, const char* colour, const Error& error) {
  FigureData data("errors");
  FigureData medians("medians");
  for (const Match& m : detection.matches) {
    if (std::isfinite(error(m))) data.row(m.truth.surface_m.z(), error(m));
  }
  if (data.empty()) return std::nullopt;
  for (const DepthFigures& b : detection.by_depth) {
    std::vector<double> values;
    for (const Match& m : detection.matches) {
      const double z_m = m.truth.surface_m.z();
      if (z_m >= b.from_m && z_m < b.to_m) values.push_back(error(m));
    }
    const auto summary = summarise(values);
    if (!summary) continue;
    medians.row(b.from_m, summary->median);
    medians.row(b.to_m, summary->median);
    medians.gap();
  }
  const std::string median_plot =
      medians.empty() ? ""
                      : ", $medians with lines lw 3 lc rgb '#24292f' title 'median of a depth bin'";
  return Figure{caption,
                data.text() + medians.text() +
                    fmt::format("set xlabel 'depth [m]'\nset ylabel '{}'\nset yrange [0:*]\n"
                                "plot $errors with points pt 7 ps 0.45 lc rgb '#70{}' "
                                "title 'each found object'{}\n",
                                label, colour, median_plot)};
}

std::optional<Figure> roc(const PointFigures& points) {
  if (points.curve.empty()) return std::nullopt;
  constexpr double kLeastRate = 1e-4;
  FigureData curve("roc");
  for (const RocPoint& p : points.curve)
    curve.row(std::max(p.false_positive_rate, kLeastRate), p.true_positive_rate);
  FigureData decision("decision");
  decision.row(std::max(points.false_positive_rate, kLeastRate), points.recall.value_or(0.0));
  return Figure{
      "Points that move: ROC",
      curve.text() + decision.text() +
          fmt::format(
              "set logscale x\nset xrange [{}:1]\nset yrange [0:1.02]\nset format x '10^{{%T}}'\n"
              "set xlabel 'false positive rate' \nset ylabel 'true positive rate'\n"
              "set key bottom right\nset xtics enhanced\n"
              "plot $roc with lines lw 2.5 lc rgb '#1f6feb' title 'threshold on speed', "
              "$decision with points pt 7 ps 1.1 lc rgb '#d1570b' title 'decision taken'\n",
              kLeastRate)};
}

// Steps over the ranges of depth.
std::optional<Figure> noise(const std::vector<NoiseFigures>& figures, const char* caption,
                            const char* label, double NoisePair::*sigma) {
  if (figures.empty()) return std::nullopt;
  FigureData data("noise");
  double to_m = 0.0;
  for (const NoiseFigures& f : figures) {
    to_m = f.to_m > 0.0 ? f.to_m : 2.0 * f.from_m;
    for (const double depth_m : {f.from_m, to_m})
      data.row(depth_m, f.learnt.*sigma, f.varying.*sigma, f.whole.*sigma);
  }
  return Figure{
      caption,
      data.text() +
          fmt::format("set xlabel 'depth [m]'\nset ylabel '{}'\nset yrange [0:*]\n"
                      "set xrange [0:{}]\nset key top left\n"
                      "plot $noise using 1:4 with lines lw 5 lc rgb '#c8ccd1' title 'true, whole', "
                      "$noise using 1:3 with lines lw 2.5 lc rgb '#24292f' title 'true, without "
                      "what a track keeps', "
                      "$noise using 1:2 with lines lw 2.5 lc rgb '#1f6feb' title 'learnt'\n",
                      label, to_m)};
}

std::vector<Figure> figures_of(const Evaluation& e) {
  std::vector<Figure> figures;
  const auto add = [&](std::optional<Figure> figure) {
    if (figure) figures.push_back(std::move(*figure));
  };
  if (e.odometry && e.odometry->scored) {
    const AlignedPoses poses = align_first(e.truth.poses, e.estimate.poses);
    add(trajectory(poses));
    add(pose_error(poses, e.truth.times_s));
  }
  if (e.detection) {
    add(speeds(e));
    add(by_depth(
        *e.detection, "Position error by depth", "position error [m]", "1f6feb",
        [](const Match& m) { return (m.estimate.position_m - m.truth.surface_m).norm(); }));
    add(by_depth(
        *e.detection, "Velocity error by depth", "velocity error [m/s]", "d1570b",
        [](const Match& m) { return (m.estimate.velocity_mps - m.truth.velocity_mps).norm(); }));
  }
  if (e.points) add(roc(*e.points));
  add(noise(e.noise, "Noise of disparities by depth", "sigma of a disparity [px]",
            &NoisePair::disparity_px));
  add(noise(e.noise, "Noise of left positions by depth", "sigma along an axis [px]",
            &NoisePair::pixel_px));
  return figures;
}

}  // namespace

std::vector<Plot> draw_plots(const Evaluation& evaluation) { return draw(figures_of(evaluation)); }

}  // namespace egomod::eval
