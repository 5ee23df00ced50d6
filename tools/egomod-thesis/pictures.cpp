// SPDX-License-Identifier: Apache-2.0
#include "pictures.hpp"

#include <array>
#include <cmath>
#include <map>

#include "plot.hpp"
#include "temporary_folder.hpp"

namespace egomod::thesis {
namespace {

using eval::Figure;
using eval::FigureData;

constexpr double kTall_px = 640.0;  // of a figure with two panels
constexpr const char* kTruth = "with lines lw 5 lc rgb '#c8ccd1'";
constexpr const char* kLimit = "with lines lw 1.2 lc rgb '#c026d3'";
constexpr const char* kThesis = "with points pt 7 ps 0.7 lc rgb '#d1570b'";
constexpr const char* kStandard = "with lines lw 1.4 lc rgb '#1f6feb'";

// Rows of time and values; lines break where the target was not seen.
template <typename Values>
std::string block(const char* name, const std::vector<Sighting>& series, const Values& values) {
  FigureData data(name);
  int last = -1;
  for (const Sighting& s : series) {
    if (last >= 0 && s.frame > last + 1) data.gap();
    last = s.frame;
    std::apply([&](auto... v) { data.row(s.time_s, v...); }, values(s));
  }
  return data.text();
}

std::string block(const char* name, const std::vector<RigSpeed>& series) {
  FigureData data(name);
  for (const RigSpeed& s : series) data.row(s.time_s, s.forward_mps);
  return data.text();
}

std::string panel(const char* label, const std::string& plots) {
  return fmt::format("set ylabel '{}'\nplot {}\n", label, plots);
}

std::string two_panels(const std::string& first, const std::string& second) {
  return "set multiplot layout 2,1\nset xlabel 'time [s]'\nset key top left\nset lmargin 9\n" +
         first + second + "unset multiplot\n";
}

// Figures 6 and 9: where the target is in the fixed frame. The thesis's x is ours, its y our z.
Figure positions(const char* caption, const Case& one) {
  const auto values = [](const Sighting& s) {
    return std::tuple(s.position_m.x(), s.position_m.z(), s.left_m, s.right_m);
  };
  const std::string data = block("truth", true_sightings(one.standard.truth), values) +
                           block("thesis", sightings(one.thesis), values) +
                           block("standard", sightings(one.standard), values);
  const std::string across = fmt::format(
      "$truth using 1:2 {} title 'truth, visible surface', "
      "$truth using 1:4 {} title 'its limits', $truth using 1:5 {} notitle, "
      "$thesis using 1:2:4:5 with yerrorbars pt 7 ps 0.7 lc rgb '#d1570b' "
      "title 'thesis, with its rectangle', $standard using 1:2 {} title 'default'",
      kTruth, kLimit, kLimit, kStandard);
  const std::string ahead = fmt::format(
      "$truth using 1:3 {} title 'truth', $thesis using 1:3 {} title 'thesis', "
      "$standard using 1:3 {} title 'default'",
      kTruth, kThesis, kStandard);
  return {caption,
          data + two_panels("set yrange [-1:1.6]\n" + panel("x, to the right [m]", across),
                            "set yrange [0:*]\n" + panel("y, ahead [m]", ahead)),
          kTall_px};
}

// Figures 7 and 10: speeds of the target and of the rig, ahead.
Figure velocities(const char* caption, const Case& one) {
  const auto ahead = [](const Sighting& s) { return std::tuple(s.velocity_mps.z()); };
  const std::vector<double>& times_s = one.standard.truth.times_s;
  const std::string data = block("truth", true_sightings(one.standard.truth), ahead) +
                           block("thesis", sightings(one.thesis), ahead) +
                           block("standard", sightings(one.standard), ahead) +
                           block("rig_truth", rig_speeds(one.standard.truth.poses, times_s)) +
                           block("rig_thesis", rig_speeds(one.thesis.estimate.poses, times_s)) +
                           block("rig_standard", rig_speeds(one.standard.estimate.poses, times_s));
  const std::string target = fmt::format(
      "$truth using 1:2 {} title 'truth', $standard using 1:2 {} title 'default', "
      "$thesis using 1:2 {} title 'thesis'",
      kTruth, kStandard, kThesis);
  const std::string rig = fmt::format(
      "$rig_truth using 1:2 {} title 'truth', $rig_standard using 1:2 {} title 'default', "
      "$rig_thesis using 1:2 {} title 'thesis'",
      kTruth, kStandard, kThesis);
  return {caption,
          data + two_panels("set yrange [-0.2:1.4]\n" + panel("target [m/s]", target),
                            "set yrange [-0.1:0.6]\n" + panel("rig [m/s]", rig)),
          kTall_px};
}

// Figures 8 and 11.
Figure errors(const char* caption, const Case& one) {
  const auto error = [](const Sighting& s) { return std::tuple(s.position_error_m); };
  return {caption, block("thesis", sightings(one.thesis), error) +
                       block("standard", sightings(one.standard), error) +
                       fmt::format("set xlabel 'time [s]'\nset ylabel 'position error [m]'\n"
                                   "set yrange [0:*]\nset key above\n"
                                   "plot $standard using 1:2 {} title 'default', "
                                   "$thesis using 1:2 {} title 'thesis'\n",
                                   kStandard, kThesis)};
}

// Share of the pairs that show the target at a depth in which it was found.
std::string found_by_depth(const char* name, const eval::Evaluation& evaluation,
                           const std::vector<int>& frames) {
  constexpr double kBin_m = 1.0;
  std::map<int, std::array<int, 2>> bins;  // found, shown
  const auto bin = [&](double depth_m) { return static_cast<int>(depth_m / kBin_m); };
  for (const Sighting& s : true_sightings(evaluation.truth)) {
    if (std::binary_search(frames.begin(), frames.end(), s.frame)) ++bins[bin(s.depth_m)][1];
  }
  int last = -1;
  for (const Sighting& s : sightings(evaluation)) {
    if (s.frame != last) ++bins[bin(s.depth_m)][0];
    last = s.frame;
  }
  FigureData data(name);
  for (const auto& [at, counts] : bins) {
    if (counts[1] == 0) continue;
    const double share = static_cast<double>(counts[0]) / counts[1];
    data.row(at * kBin_m, share);
    data.row((at + 1) * kBin_m, share);
  }
  return data.text();
}

std::vector<int> frames_of(const eval::Evaluation& evaluation) {
  std::vector<int> frames;
  for (const eval::NumberedPose& pose : evaluation.estimate.poses) frames.push_back(pose.frame);
  return frames;
}

Figure range_of(const Case& one, const eval::Evaluation& narrow) {
  return {
      "Range: share of the pairs in which a target that drives away was found, by its depth",
      found_by_depth("thesis", one.thesis, frames_of(one.thesis)) +
          found_by_depth("narrow", narrow, frames_of(narrow)) +
          found_by_depth("standard", one.standard, frames_of(one.standard)) +
          fmt::format("set xlabel 'depth [m]'\nset ylabel 'share found'\nset yrange [0:1.1]\n"
                      "set xrange [0:*]\nset key above\n"
                      "set arrow from {0},0 to {0},1.1 nohead dt 2 lc rgb '#57606a'\n"
                      "set arrow from {1},0 to {1},1.1 nohead dt 2 lc rgb '#57606a'\n"
                      "set label '{0} m' at {0},1.05 offset 0.5,0\n"
                      "set label 'published: {1} m' at {1},1.05 right offset -0.5,0\n"
                      "plot $standard using 1:2 with lines lw 2 lc rgb '#1f6feb' title 'default', "
                      "$narrow using 1:2 with lines lw 2 dt 2 lc rgb '#2a8a4a' "
                      "title 'thesis, gate of 1 px', "
                      "$thesis using 1:2 with lines lw 2 lc rgb '#d1570b' title 'thesis'\n",
                      kPublishedNearest_m, kPublishedFarthest_m)};
}

eval::Plot decision_of(const ThresholdFit& fit) {
  const eval::TemporaryFolder folder;
  return {"Figure 5: likelihood of a point's speed given its class, and the posterior",
          eval::svg_of(fit::draw_figure(folder.path(), "svg", fit.labels, fit.model))};
}

}  // namespace

std::vector<std::pair<std::string, const eval::Plot*>> Pictures::all() const {
  std::vector<std::pair<std::string, const eval::Plot*>> named{{"figure-05", &decision}};
  constexpr std::array<const char*, 6> kNames{"figure-06", "figure-07", "figure-08",
                                              "figure-09", "figure-10", "figure-11"};
  std::size_t next = 0;
  for (const auto* plots : {&still, &moving}) {
    for (const eval::Plot& plot : *plots) named.emplace_back(kNames.at(next++), &plot);
  }
  named.emplace_back("range", &range);
  return named;
}

Pictures draw_pictures(const ThresholdFit& decision, const Case& still, const Case& moving,
                       const Case& range, const eval::Evaluation& range_narrow_gate) {
  Pictures pictures;
  pictures.decision = decision_of(decision);
  pictures.still = eval::draw({positions("Figure 6: the target's position, rig at rest", still),
                               velocities("Figure 7: speed of target and rig, rig at rest", still),
                               errors("Figure 8: error of the position, rig at rest", still)});
  pictures.moving =
      eval::draw({positions("Figure 9: the target's position, rig moving", moving),
                  velocities("Figure 10: speed of target and rig, rig moving", moving),
                  errors("Figure 11: error of the position, rig moving", moving)});
  pictures.range = eval::draw({range_of(range, range_narrow_gate)}).front();
  return pictures;
}

}  // namespace egomod::thesis
