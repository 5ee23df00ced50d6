// SPDX-License-Identifier: Apache-2.0
#include "compare.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "csv.hpp"

namespace egomod::demo {
namespace {

namespace fs = std::filesystem;

constexpr double kMinOverlap = 0.3;
constexpr int kMinVisible_px = 400;
constexpr double kMaxOccluded = 0.5;

struct Rectangle {
  double u_min, v_min, u_max, v_max;
  [[nodiscard]] double area() const {
    return std::max(0.0, u_max - u_min + 1.0) * std::max(0.0, v_max - v_min + 1.0);
  }
  [[nodiscard]] bool contains(double u, double v) const {
    return u >= u_min && u <= u_max && v >= v_min && v <= v_max;
  }
};

Rectangle rectangle(const Csv& csv, std::size_t row) {
  return {csv.number(row, "u_min"), csv.number(row, "v_min"), csv.number(row, "u_max"),
          csv.number(row, "v_max")};
}

double speed_mps(const Csv& csv, std::size_t row) {
  return std::hypot(csv.number(row, "VX"), csv.number(row, "VY"), csv.number(row, "VZ"));
}

bool on(const Rectangle& estimate, const Rectangle& truth) {
  const Rectangle both{std::max(estimate.u_min, truth.u_min), std::max(estimate.v_min, truth.v_min),
                       std::min(estimate.u_max, truth.u_max),
                       std::min(estimate.v_max, truth.v_max)};
  const double intersection = both.area();
  return intersection >= kMinOverlap * (estimate.area() + truth.area() - intersection) ||
         truth.contains(0.5 * (estimate.u_min + estimate.u_max),
                        0.5 * (estimate.v_min + estimate.v_max));
}

std::vector<Eigen::Vector3d> positions(const fs::path& poses) {
  std::vector<Eigen::Vector3d> out;
  for (const auto& row : read_numbers(poses, 12)) out.emplace_back(row[3], row[7], row[11]);
  return out;
}

double length_m(const std::vector<Eigen::Vector3d>& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

std::map<int, std::vector<std::size_t>> rows_by_frame(const Csv& csv) {
  std::map<int, std::vector<std::size_t>> rows;
  for (std::size_t row = 0; row < csv.rows(); ++row) {
    rows[static_cast<int>(csv.number(row, "frame"))].push_back(row);
  }
  return rows;
}

// The not yet used estimate of this frame that lies on `truth`.
const std::size_t* find_on(const Csv& estimates, const std::vector<std::size_t>& rows,
                           const std::set<std::size_t>& used, const Rectangle& truth) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](std::size_t row) {
    return !used.contains(row) && on(rectangle(estimates, row), truth);
  });
  return found == rows.end() ? nullptr : &*found;
}

void count(const Csv& truth, std::size_t row, const Csv& estimates, const std::size_t* estimate,
           ObjectComparison& object, double& due_since_s) {
  const double t_s = truth.number(row, "time");
  if (object.due++ == 0) due_since_s = t_s;
  object.mean_speed_mps += speed_mps(truth, row);
  if (estimate == nullptr) return;
  if (object.found++ == 0) object.first_seen_s = t_s - due_since_s;
  object.speed_error_rms_mps +=
      std::pow(speed_mps(estimates, *estimate) - speed_mps(truth, row), 2);
}

double quantile(std::vector<double>& sorted, double q) {
  return sorted[static_cast<std::size_t>(std::lround(q * static_cast<double>(sorted.size() - 1)))];
}

void print_objects(const ObjectsComparison& result) {
  for (const auto& [id, object] : result.objects) {
    if (object.due == 0) continue;
    fmt::print("robot {}    {:.2f} m/s, seen in {} of the {} pairs in which it moves in view", id,
               object.mean_speed_mps, object.found, object.due);
    if (object.found > 0) {
      fmt::print(", first after {:.2f} s; speed off by {:.3f} m/s rms", object.first_seen_s,
                 object.speed_error_rms_mps);
    }
    fmt::print("\n");
  }
  fmt::print("strays     {} of {} boxes lie on nothing that moves\n", result.strays,
             result.estimates);
}

}  // namespace

std::string drift_text(const PathComparison& path) {
  constexpr double kShortest_m = 0.1;
  if (path.length_m < kShortest_m) return {};
  return fmt::format(": {:.2f} % drift", 100.0 * path.end_error_m / path.length_m);
}

PathComparison compare_paths(const fs::path& sequence, const fs::path& result) {
  const auto truth = positions(sequence / "poses.txt");
  const auto estimate = positions(result / "poses.txt");
  if (truth.size() != estimate.size() || truth.empty()) {
    throw std::runtime_error(fmt::format("{} poses estimated, {} are true: was every pair read?",
                                         estimate.size(), truth.size()));
  }
  PathComparison out;
  out.pairs = static_cast<int>(truth.size());
  out.length_m = length_m(truth);
  out.estimated_m = length_m(estimate);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    out.end_error_m = (estimate[i] - truth[i]).norm();
    out.worst_error_m = std::max(out.worst_error_m, out.end_error_m);
  }
  return out;
}

ObjectsComparison compare_objects(const fs::path& sequence, const fs::path& result) {
  const Csv truth(sequence / "objects.csv");
  const Csv estimates(result / "objects.csv");
  const auto estimated = rows_by_frame(estimates);
  ObjectsComparison out;
  out.estimates = static_cast<int>(estimates.rows());
  std::map<int, double> due_since_s;
  std::set<std::size_t> used;
  for (std::size_t row = 0; row < truth.rows(); ++row) {
    if (truth.number(row, "moving") == 0.0) continue;
    const auto frame = estimated.find(static_cast<int>(truth.number(row, "frame")));
    const std::size_t* estimate =
        frame == estimated.end() ? nullptr
                                 : find_on(estimates, frame->second, used, rectangle(truth, row));
    if (estimate != nullptr) used.insert(*estimate);
    if (truth.number(row, "visible_px") < kMinVisible_px ||
        truth.number(row, "occlusion_fraction") > kMaxOccluded) {
      continue;
    }
    const int id = static_cast<int>(truth.number(row, "object_id"));
    count(truth, row, estimates, estimate, out.objects[id], due_since_s[id]);
  }
  for (auto& [id, object] : out.objects) {
    object.mean_speed_mps /= object.due;
    object.speed_error_rms_mps = std::sqrt(object.speed_error_rms_mps / std::max(1, object.found));
  }
  out.strays = out.estimates - static_cast<int>(used.size());
  return out;
}

std::map<std::string, StageLatency> latencies(const fs::path& result) {
  if (!fs::exists(result / "timing.csv")) return {};
  const Csv timing(result / "timing.csv");
  std::map<std::string, std::vector<double>> stages;
  for (std::size_t row = 0; row < timing.rows(); ++row) {
    stages[timing.text(row, "stage")].push_back(timing.number(row, "ms"));
  }
  std::map<std::string, StageLatency> out;
  for (auto& [stage, ms] : stages) {
    std::sort(ms.begin(), ms.end());
    out[stage] = {quantile(ms, 0.5), quantile(ms, 0.99)};
  }
  return out;
}

void print_comparison(const fs::path& sequence, const fs::path& result, double elapsed_s) {
  const PathComparison path = compare_paths(sequence, result);
  fmt::print("pairs      {} in {:.1f} s: {:.0f} a second, start and end of the program included\n",
             path.pairs, elapsed_s, path.pairs / elapsed_s);
  for (const auto& [stage, latency] : latencies(result)) {
    fmt::print("latency    {:<16} median {:6.2f} ms, 99 % below {:6.2f} ms\n", stage,
               latency.median_ms, latency.p99_ms);
  }
  fmt::print("path       {:.3f} m ({:.3f} m are true); ends {:.1f} mm from the truth{}\n",
             path.estimated_m, path.length_m, 1e3 * path.end_error_m, drift_text(path));
  print_objects(compare_objects(sequence, result));
}

}  // namespace egomod::demo
