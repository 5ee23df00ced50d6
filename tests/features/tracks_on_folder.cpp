// SPDX-License-Identifier: Apache-2.0
// Developer program: the tracker on every n-th pair of a folder with poses.txt, judged by them.
// Tracks inside the rectangles of what moves or is not labelled (objects.csv, when there) are only
// counted.
//   tracks_on_folder DIR [EVERY] [WORST]    WORST: the file that takes the tracks 3 px off
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "egomod/capture/frame_source.hpp"
#include "egomod/core/geometry.hpp"
#include "egomod/core/moving_objects.hpp"
#include "egomod/features/feature_tracker.hpp"

namespace egomod {
namespace {

constexpr double kFarOff_px = 3.0;
constexpr double kDontCareId = 900;
constexpr std::array<std::uint32_t, 5> kAgeStarts{1, 2, 4, 8, 16};

struct Truth {
  std::vector<Eigen::Isometry3d> T_first_current;
  std::vector<std::vector<PixelRect>> ignored;  // by pair
};

struct Figures {
  std::vector<double> step_px, disparity_px, milliseconds;
  std::array<std::vector<double>, kAgeStarts.size()> chi2, step_by_age_px;
  double pairs = 0, tracks = 0, with_stereo = 0, judged = 0, ignored = 0;
};

std::vector<Eigen::Isometry3d> read_poses(const std::string& name) {
  std::ifstream file(name);
  if (!file) throw std::runtime_error("cannot read " + name);
  std::vector<Eigen::Isometry3d> poses;
  std::array<double, 12> row{};
  while (std::all_of(row.begin(), row.end(), [&](double& x) { return bool(file >> x); })) {
    Eigen::Isometry3d& T = poses.emplace_back(Eigen::Isometry3d::Identity());
    T.matrix().topRows<3>() =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(row.data());
  }
  return poses;
}

// frame, id, ..., rectangle in columns 16 to 19, moving in 22.
std::vector<std::vector<PixelRect>> read_ignored(const std::string& name, std::size_t pairs) {
  std::vector<std::vector<PixelRect>> ignored(pairs);
  std::ifstream file(name);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::vector<double> row;
    std::istringstream words(line);
    for (std::string word; std::getline(words, word, ',');)
      row.push_back(std::strtod(word.c_str(), nullptr));
    const auto frame = static_cast<std::size_t>(row.at(0));
    if ((row.at(22) == 0.0 && row[2] < kDontCareId) || frame >= pairs) continue;
    ignored[frame].push_back({static_cast<float>(row[16]), static_cast<float>(row[17]),
                              static_cast<float>(row[18]), static_cast<float>(row[19])});
  }
  return ignored;
}

bool is_inside(const std::vector<PixelRect>& rectangles, const StereoObservation& o) {
  return std::any_of(rectangles.begin(), rectangles.end(), [&](const PixelRect& r) {
    return o.u_px >= r.u_min_px && o.u_px <= r.u_max_px && o.v_px >= r.v_min_px &&
           o.v_px <= r.v_max_px;
  });
}

std::size_t age_class(std::uint32_t age) {
  const auto above = std::upper_bound(kAgeStarts.begin(), kAgeStarts.end(), age);
  return static_cast<std::size_t>(above - kAgeStarts.begin()) - 1;
}

void judge(const TrackSet& tracks, const Track& t, const Eigen::Isometry3d& T_current_previous,
           Figures& figures, std::FILE* worst) {
  const Eigen::Vector3d Q = T_current_previous * triangulate(tracks.camera, uvd(t.previous));
  if (Q.z() < 0.1) return;
  const Eigen::Vector3d r = uvd(t.current) - project(tracks.camera, Q);
  const Eigen::Matrix3d J = project_jacobian(tracks.camera, Q) * T_current_previous.linear() *
                            triangulate_jacobian(tracks.camera, uvd(t.previous));
  const Eigen::Matrix3d S = covariance(t.current) + J * covariance(t.previous) * J.transpose();
  figures.judged += 1;
  figures.step_px.push_back(r.head<2>().norm());
  figures.disparity_px.push_back(std::abs(r.z()));
  figures.chi2[age_class(t.age)].push_back(r.dot(S.inverse() * r));
  figures.step_by_age_px[age_class(t.age)].push_back(r.head<2>().norm());
  if (worst == nullptr || r.head<2>().norm() < kFarOff_px) return;
  std::fprintf(
      worst,
      "%llu %llu age %u uvd %.1f %.1f %.2f from %.1f %.1f %.2f off %.1f %.1f %.2f ncc %.3f %.3f\n",
      static_cast<unsigned long long>(tracks.sequence), static_cast<unsigned long long>(t.id),
      t.age, double(t.current.u_px), double(t.current.v_px), double(t.current.disparity_px),
      double(t.previous.u_px), double(t.previous.v_px), double(t.previous.disparity_px), r.x(),
      r.y(), r.z(), double(t.ncc), double(t.ncc_right));
}

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

void print(const std::string& folder, Figures& f) {
  std::printf(
      "%s: %.0f pairs, %.0f tracks a pair, %.1f %% with stereo, %.0f judged, %.1f ignored\n",
      folder.c_str(), f.pairs, f.tracks / f.pairs, 100 * f.with_stereo / f.tracks,
      f.judged / f.pairs, f.ignored / f.pairs);
  const auto far_off =
      std::count_if(f.step_px.begin(), f.step_px.end(), [](double x) { return x > kFarOff_px; });
  std::printf("  step px       median %.4f  p90 %.3f  far off %.1f %%\n", quantile(f.step_px, 0.5),
              quantile(f.step_px, 0.9), 100.0 * static_cast<double>(far_off) / f.judged);
  std::printf("  disparity px  median %.4f  p90 %.3f\n", quantile(f.disparity_px, 0.5),
              quantile(f.disparity_px, 0.9));
  std::printf("  CPU ms a pair p50 %.2f  p90 %.2f  max %.2f\n", quantile(f.milliseconds, 0.5),
              quantile(f.milliseconds, 0.9), quantile(f.milliseconds, 1.0));
  for (std::size_t i = 0; i < kAgeStarts.size(); ++i)
    std::printf(
        "  age %2u up: %6zu steps, px median %.3f p90 %.3f, chi2 (3) median %.2f p90 %.1f\n",
        kAgeStarts[i], f.chi2[i].size(), quantile(f.step_by_age_px[i], 0.5),
        quantile(f.step_by_age_px[i], 0.9), quantile(f.chi2[i], 0.5), quantile(f.chi2[i], 0.9));
}

void run(const std::string& folder, std::uint64_t every, std::FILE* worst) {
  const auto source = open_source("folder:" + folder, CaptureConfig{}, "", "");
  Truth truth{.T_first_current = read_poses(folder + "/poses.txt"), .ignored = {}};
  truth.ignored = read_ignored(folder + "/objects.csv", truth.T_first_current.size());
  FeatureTracker tracker{FeaturesConfig{}};
  StereoPair pair;
  TrackSet tracks;
  Figures figures;
  while (source->next(pair, {}) == SourceState::kPair && pair.sequence < truth.ignored.size()) {
    if (pair.sequence % every != 0) continue;
    const std::clock_t start = std::clock();
    tracker.track(pair, tracks);
    const double ms = 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (pair.sequence == 0) continue;
    const Eigen::Isometry3d T_current_previous = truth.T_first_current[pair.sequence].inverse() *
                                                 truth.T_first_current[pair.sequence - every];
    figures.milliseconds.push_back(ms);
    figures.pairs += 1;
    for (const Track& t : tracks.tracks) {
      figures.tracks += 1;
      figures.with_stereo += t.has_current ? 1 : 0;
      if (!t.has_current || !t.has_previous) continue;
      if (is_inside(truth.ignored[pair.sequence], t.current)) {
        figures.ignored += 1;
      } else {
        judge(tracks, t, T_current_previous, figures, worst);
      }
    }
  }
  print(folder, figures);
}

}  // namespace
}  // namespace egomod

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: %s DIR [EVERY] [WORST]\n", argv[0]);
    return 2;
  }
  try {
    std::FILE* const worst = argc > 3 ? std::fopen(argv[3], "w") : nullptr;
    egomod::run(argv[1], argc > 2 ? std::stoul(argv[2]) : 1, worst);
    if (worst != nullptr) std::fclose(worst);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
