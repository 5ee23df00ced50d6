// SPDX-License-Identifier: Apache-2.0
#include "points.hpp"

#include <algorithm>

#include "point_truth.hpp"

namespace egomod::eval {
namespace {

constexpr std::size_t kCurvePoints = 400;

struct Labelled {
  double speed_mps;
  bool moving;
};

// From the strictest threshold to none; area by trapezoids.
void sweep(std::vector<Labelled> points, PointFigures& figures) {
  std::sort(points.begin(), points.end(),
            [](const Labelled& a, const Labelled& b) { return a.speed_mps > b.speed_mps; });
  std::vector<RocPoint> curve{{points.front().speed_mps, 0.0, 0.0}};
  double area = 0.0;
  int tp = 0;
  int fp = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    ++(points[i].moving ? tp : fp);
    if (i + 1 < points.size() && points[i + 1].speed_mps == points[i].speed_mps) continue;
    const RocPoint next{points[i].speed_mps, static_cast<double>(fp) / figures.still,
                        static_cast<double>(tp) / figures.moving};
    area += 0.5 * (next.true_positive_rate + curve.back().true_positive_rate) *
            (next.false_positive_rate - curve.back().false_positive_rate);
    curve.push_back(next);
  }
  figures.area = area;
  const std::size_t step = std::max<std::size_t>(1, curve.size() / kCurvePoints);
  for (std::size_t i = 0; i < curve.size(); i += step) figures.curve.push_back(curve[i]);
  if (figures.curve.back().true_positive_rate < 1.0 ||
      figures.curve.back().false_positive_rate < 1.0) {
    figures.curve.push_back(curve.back());
  }
}

}  // namespace

PointFigures score_points(const Truth& truth, const std::vector<PointEvidence>& points,
                          int first_frame) {
  PointFigures figures;
  PointTruth on(truth);
  std::vector<Labelled> labelled;
  for (const PointEvidence& point : points) {
    if (point.frame < first_frame || point.frame >= truth.frames()) continue;
    const auto moving = on.moves(point);
    if (!moving) {
      ++figures.left_out;
      continue;
    }
    labelled.push_back({point.speed_mps, *moving});
    ++(*moving ? figures.moving : figures.still);
    figures.tp += *moving && point.moving ? 1 : 0;
    figures.fp += !*moving && point.moving ? 1 : 0;
    figures.fn += *moving && !point.moving ? 1 : 0;
  }
  const auto share = [](int part, int whole) {
    return whole == 0 ? std::nullopt : std::optional(static_cast<double>(part) / whole);
  };
  figures.precision = share(figures.tp, figures.tp + figures.fp);
  figures.recall = share(figures.tp, figures.moving);
  figures.f1 = share(2 * figures.tp, 2 * figures.tp + figures.fp + figures.fn);
  figures.false_positive_rate = share(figures.fp, figures.still).value_or(0.0);
  if (figures.moving > 0 && figures.still > 0) sweep(std::move(labelled), figures);
  return figures;
}

}  // namespace egomod::eval
