// SPDX-License-Identifier: Apache-2.0
#include "speed_radar.hpp"

#include <cmath>

#include "egomod/core/speed_units.hpp"

namespace egomod::eval {
namespace {

class SpeedSum {
 public:
  void add(const Match& m) {
    const double true_mps = m.truth.velocity_mps.norm();
    const double speed_mps = m.estimate.velocity_mps.norm();
    const double error_mps = speed_mps - true_mps;
    ++pairs_;
    true_mps_ += true_mps;
    speed_mps_ += speed_mps;
    error2_m2ps2_ += error_mps * error_mps;
    const double sigma_mps = m.estimate.speed_sigma_mps.value_or(0.0);
    if (!(sigma_mps > 0.0) || !std::isfinite(sigma_mps)) return;
    ++with_sigma_;
    sigma_mps_ += sigma_mps;
    within_ += std::abs(error_mps) <= sigma_mps ? 1.0 : 0.0;
    error2_by_variance_ += std::pow(error_mps / sigma_mps, 2);
  }

  [[nodiscard]] SpeedFigures figures() const {
    const auto n = static_cast<double>(pairs_);
    SpeedFigures figures{.pairs = pairs_,
                         .true_mps = true_mps_ / n,
                         .mean_mps = speed_mps_ / n,
                         .rmse_mps = std::sqrt(error2_m2ps2_ / n),
                         .sigma_mps = std::nullopt,
                         .within_sigma = std::nullopt,
                         .error2_by_variance = std::nullopt};
    if (with_sigma_ == 0) return figures;
    const auto known = static_cast<double>(with_sigma_);
    figures.sigma_mps = sigma_mps_ / known;
    figures.within_sigma = within_ / known;
    figures.error2_by_variance = error2_by_variance_ / known;
    return figures;
  }

 private:
  std::size_t pairs_ = 0, with_sigma_ = 0;
  double true_mps_ = 0.0, speed_mps_ = 0.0, error2_m2ps2_ = 0.0;
  double sigma_mps_ = 0.0, within_ = 0.0, error2_by_variance_ = 0.0;
};

}  // namespace

std::optional<double> SpeedFigures::sigma_kmh() const {
  return sigma_mps ? std::optional(kKmhPerMps * *sigma_mps) : std::nullopt;
}

std::optional<SpeedRadar> score_speeds(const std::vector<Match>& matches) {
  std::map<std::string, SpeedSum> sums;
  SpeedSum all;
  for (const Match& m : matches) {
    if (!m.estimate.velocity_mps.allFinite()) continue;
    sums[m.truth.id].add(m);
    all.add(m);
  }
  if (sums.empty()) return std::nullopt;
  SpeedRadar radar{.objects = {}, .all = all.figures()};
  for (const auto& [id, sum] : sums) radar.objects[id] = sum.figures();
  return radar;
}

}  // namespace egomod::eval
