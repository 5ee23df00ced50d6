// SPDX-License-Identifier: Apache-2.0
#include "detection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>

#include "duty.hpp"

namespace egomod::eval {
namespace {

constexpr double kLeastOverlap = 0.3;
constexpr double kFar_m = 1e9;
constexpr std::array<double, 12> kDepthEdges_m{0, 1, 2, 3, 4, 6, 8, 10, 12, 15, 20, 40};

// Overlap, if the estimate counts as lying on the object.
std::optional<double> lies_on(const Detection& estimate, const TruthObject& object) {
  if (object.visible_px <= 0) return std::nullopt;
  const double iou = overlap(estimate.rectangle, object.rectangle);
  const Rectangle& r = estimate.rectangle;
  const bool inside =
      object.rectangle.contains(0.5 * (r.u_min_px + r.u_max_px), 0.5 * (r.v_min_px + r.v_max_px));
  return iou >= kLeastOverlap || inside ? std::optional(iou) : std::nullopt;
}

struct IndexPair {
  std::size_t estimate, object;
};

// One to one, greedily: the greatest overlap first, then the nearest in space.
std::vector<IndexPair> match(const std::vector<Detection>& estimates,
                             const std::vector<const TruthObject*>& objects) {
  std::vector<std::tuple<double, double, std::size_t, std::size_t>> candidates;
  for (std::size_t e = 0; e < estimates.size(); ++e) {
    for (std::size_t o = 0; o < objects.size(); ++o) {
      const auto iou = lies_on(estimates[e], *objects[o]);
      if (!iou) continue;
      const double distance_m = (estimates[e].position_m - objects[o]->surface_m).norm();
      candidates.emplace_back(-*iou, std::isfinite(distance_m) ? distance_m : kFar_m, e, o);
    }
  }
  std::sort(candidates.begin(), candidates.end());
  std::set<std::size_t> used_estimates;
  std::set<std::size_t> used_objects;
  std::vector<IndexPair> matches;
  for (const auto& [iou, distance_m, e, o] : candidates) {
    if (used_estimates.count(e) != 0 || used_objects.count(o) != 0) continue;
    used_estimates.insert(e);
    used_objects.insert(o);
    matches.push_back({e, o});
  }
  return matches;
}

struct History {
  std::string type;
  int due = 0;
  int found = 0;
  double first_s = 0.0;
  std::optional<double> seen_s;
  std::vector<std::string> tracks;
};

class Tally {
 public:
  Tally(const Truth& truth, const ByFrame<Detection>& detections, const DetectionOptions& options)
      : truth_(truth),
        detections_(detections),
        counted_(counted_frames(truth.frames(), options)),
        duties_(duties(truth, counted_, options)) {
    figures_.frames = std::max(1, static_cast<int>(counted_.size()));
    figures_.duration_s = figures_.frames / counted_rate_hz(truth, options);
  }

  DetectionFigures run() {
    check_rows();
    for (const int frame : counted_) add(frame);
    rates();
    errors();
    depths();
    objects();
    return std::move(figures_);
  }

 private:
  void check_rows() {
    for (const auto& [frame, rows] : detections_) {
      if (frame >= truth_.frames()) {
        figures_.rows_outside += static_cast<int>(rows.size());
        continue;
      }
      for (const Detection& row : rows) {
        const double off_s = std::abs(row.time_s - truth_.times_s[static_cast<std::size_t>(frame)]);
        if (std::isfinite(off_s))
          figures_.time_mismatch_s = std::max(figures_.time_mismatch_s.value_or(0.0), off_s);
      }
    }
  }

  void add(int frame) {
    const auto truth_at = truth_.objects->find(frame);
    const auto estimates_at = detections_.find(frame);
    const std::vector<TruthObject> none;
    const std::vector<Detection> nothing;
    const auto& all = truth_at == truth_.objects->end() ? none : truth_at->second;
    const auto& estimates = estimates_at == detections_.end() ? nothing : estimates_at->second;
    std::vector<const TruthObject*> wanted;
    std::vector<Duty> wanted_duty;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Duty duty = duties_.at(frame)[i];
      if (duty != Duty::kDue && duty != Duty::kGrace) continue;
      wanted.push_back(&all[i]);
      wanted_duty.push_back(duty);
      expect(all[i], duty);
    }
    std::vector<bool> used(estimates.size(), false);
    for (const auto& [e, o] : match(estimates, wanted)) {
      used[e] = true;
      take(frame, estimates[e], *wanted[o], wanted_duty[o]);
    }
    for (std::size_t e = 0; e < estimates.size(); ++e) {
      if (!used[e]) leave(frame, estimates[e], all);
    }
  }

  void expect(const TruthObject& object, Duty duty) {
    const auto [at, fresh] = histories_.try_emplace(object.id);
    History& history = at->second;
    if (fresh) {
      history.type = object.type;
      history.first_s = object.time_s;
    }
    if (duty != Duty::kDue) return;
    ++history.due;
    ++figures_.fn;  // until it is found
    due_depths_m_.push_back(object.surface_m.z());
  }

  void take(int frame, const Detection& estimate, const TruthObject& object, Duty duty) {
    History& history = histories_[object.id];
    if (!history.seen_s) history.seen_s = object.time_s;
    history.tracks.push_back(estimate.track);
    figures_.matches.push_back({frame, estimate, object, duty});
    if (duty != Duty::kDue) return;
    ++history.found;
    ++figures_.tp;
    --figures_.fn;
  }

  // An estimate that is nobody's.
  void leave(int frame, const Detection& estimate, const std::vector<TruthObject>& objects) {
    std::set<Duty> hit;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      if (!lies_on(estimate, objects[i])) continue;
      const Duty duty = duties_.at(frame)[i];
      hit.insert(duty);
      if (duty == Duty::kOther && objects[i].moving) see_depth(objects[i].surface_m.z());
    }
    if (hit.count(Duty::kDue) != 0) {
      ++figures_.fp;
      ++figures_.duplicates;
    } else if (hit.count(Duty::kGrace) != 0 || hit.count(Duty::kOther) != 0) {
      ++figures_.ignored;
    } else {
      ++figures_.fp;
      figures_.fp_on_still += hit.count(Duty::kStill) != 0 ? 1 : 0;
    }
  }

  void see_depth(double depth_m) {
    figures_.max_depth_any_m = std::max(figures_.max_depth_any_m.value_or(depth_m), depth_m);
  }

  void rates() {
    const auto share = [](int part, int whole) {
      return whole == 0 ? std::nullopt : std::optional(static_cast<double>(part) / whole);
    };
    DetectionFigures& f = figures_;
    f.precision = share(f.tp, f.tp + f.fp);
    f.recall = share(f.tp, f.tp + f.fn);
    f.f1 = share(2 * f.tp, 2 * f.tp + f.fp + f.fn);
    f.false_per_pair = static_cast<double>(f.fp) / f.frames;
    f.false_per_minute = f.fp / (f.duration_s / 60.0);
  }

  template <typename Error>
  [[nodiscard]] std::optional<Summary> over(const Error& error, double from_m = -kFar_m,
                                            double to_m = kFar_m) const {
    std::vector<double> values;
    for (const Match& m : figures_.matches) {
      const double z_m = m.truth.surface_m.z();
      if (z_m >= from_m && z_m < to_m) values.push_back(error(m));
    }
    return summarise(std::move(values));
  }

  static Eigen::Vector3d offset(const Match& m) {
    return m.estimate.position_m - m.truth.surface_m;
  }
  static double position_error(const Match& m) { return offset(m).norm(); }
  static double velocity_error(const Match& m) {
    return (m.estimate.velocity_mps - m.truth.velocity_mps).norm();
  }
  static double speed_error(const Match& m) {
    return std::abs(m.estimate.velocity_mps.norm() - m.truth.velocity_mps.norm());
  }

  void errors() {
    DetectionFigures& f = figures_;
    f.position_m = over(position_error);
    f.position_percent =
        over([](const Match& m) { return 100.0 * position_error(m) / m.truth.surface_m.z(); });
    f.position_axial_m = over([](const Match& m) { return std::abs(offset(m).z()); });
    f.position_lateral_m = over([](const Match& m) { return offset(m).head<2>().norm(); });
    f.position_to_centre_m =
        over([](const Match& m) { return (m.estimate.position_m - m.truth.centre_m).norm(); });
    f.velocity_mps = over(velocity_error);
    f.speed_mps = over(speed_error);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int known = 0;
    for (const Match& m : f.matches) {
      const double z_m = m.truth.surface_m.z();
      f.min_depth_m = std::min(f.min_depth_m.value_or(z_m), z_m);
      f.max_depth_m = std::max(f.max_depth_m.value_or(z_m), z_m);
      see_depth(z_m);
      if (!m.estimate.velocity_mps.allFinite()) continue;
      sum += m.estimate.velocity_mps - m.truth.velocity_mps;
      ++known;
    }
    if (known > 0) f.velocity_bias_mps = sum / known;
  }

  void depths() {
    for (std::size_t i = 0; i + 1 < kDepthEdges_m.size(); ++i) {
      const double from_m = kDepthEdges_m[i];
      const double to_m = kDepthEdges_m[i + 1];
      const auto within = [&](double z_m) { return z_m >= from_m && z_m < to_m; };
      const auto due = std::count_if(due_depths_m_.begin(), due_depths_m_.end(), within);
      if (due == 0) continue;
      const auto found = std::count_if(
          figures_.matches.begin(), figures_.matches.end(),
          [&](const Match& m) { return m.duty == Duty::kDue && within(m.truth.surface_m.z()); });
      figures_.by_depth.push_back({from_m, to_m, static_cast<int>(due),
                                   static_cast<double>(found) / static_cast<double>(due),
                                   over(position_error, from_m, to_m),
                                   over(velocity_error, from_m, to_m),
                                   over(speed_error, from_m, to_m)});
    }
  }

  void objects() {
    std::vector<double> delays_s;
    for (const auto& [id, history] : histories_) {
      ObjectFigures object{.type = history.type,
                           .due = history.due,
                           .found = history.found,
                           .delay_s = std::nullopt};
      for (std::size_t i = 1; i < history.tracks.size(); ++i)
        object.switches += history.tracks[i] != history.tracks[i - 1] ? 1 : 0;
      object.tracks = static_cast<int>(
          std::set<std::string>(history.tracks.begin(), history.tracks.end()).size());
      if (history.seen_s) {
        object.delay_s = *history.seen_s - history.first_s;
        delays_s.push_back(*object.delay_s);
      } else {
        ++figures_.never_detected;
      }
      figures_.switches += object.switches;
      figures_.objects[id] = object;
    }
    figures_.delay_s = summarise(delays_s);
  }

  const Truth& truth_;
  const ByFrame<Detection>& detections_;
  std::vector<int> counted_;
  std::map<int, std::vector<Duty>> duties_;
  std::map<std::string, History> histories_;
  std::vector<double> due_depths_m_;
  DetectionFigures figures_;
};

}  // namespace

double overlap(const Rectangle& a, const Rectangle& b) {
  const auto area = [](const Rectangle& r) {
    return (r.u_max_px - r.u_min_px + 1.0) * (r.v_max_px - r.v_min_px + 1.0);
  };
  const double width = std::min(a.u_max_px, b.u_max_px) - std::max(a.u_min_px, b.u_min_px) + 1.0;
  const double height = std::min(a.v_max_px, b.v_max_px) - std::max(a.v_min_px, b.v_min_px) + 1.0;
  if (!(width > 0.0 && height > 0.0)) return 0.0;
  return width * height / (area(a) + area(b) - width * height);
}

DetectionFigures score_detection(const Truth& truth, const ByFrame<Detection>& detections,
                                 const DetectionOptions& options) {
  return Tally(truth, detections, options).run();
}

}  // namespace egomod::eval
