// SPDX-License-Identifier: Apache-2.0
#include "deliveries.hpp"

#include <limits>

namespace egomod::sim {
namespace {

constexpr double kNever_s = std::numeric_limits<double>::infinity();

double time_s(const std::optional<Exposure>& exposure) {
  return exposure ? exposure->t_s : kNever_s;
}

}  // namespace

Deliveries::Deliveries(const World& world)
    : world_(world), in_pairs_(world.timing.comes_in_pairs()) {
  coming_[0] = following(Eye::kLeft, 0);
  if (!in_pairs_) coming_[1] = following(Eye::kRight, 0);
}

std::optional<Exposure> Deliveries::following(Eye eye, std::uint64_t number) const {
  for (;; ++number) {
    const Exposure next = exposure(world_, eye, number);
    if (!world_.is_endless() && next.t_s >= world_.duration_s - 1e-9) return std::nullopt;
    if (next.t_s >= 0.0 && !is_lost(world_, eye, number)) return next;
  }
}

Eye Deliveries::earlier() const {
  return time_s(coming_[1]) < time_s(coming_[0]) ? Eye::kRight : Eye::kLeft;
}

void Deliveries::expose() {
  const Eye eye = earlier();
  auto& coming = coming_[static_cast<std::size_t>(eye)];
  under_way_.push({eye, in_pairs_, exposed_[static_cast<std::size_t>(eye)]++, *coming});
  coming = following(eye, coming->number + 1);
}

std::optional<Delivery> Deliveries::next() {
  const auto may_be_overtaken = [&] {
    const double next_s = time_s(coming_[static_cast<std::size_t>(earlier())]);
    return under_way_.empty() ? next_s < kNever_s : next_s < under_way_.top().arrival_s();
  };
  while (may_be_overtaken()) expose();
  if (under_way_.empty()) return std::nullopt;
  const Delivery first = under_way_.top();
  under_way_.pop();
  return first;
}

}  // namespace egomod::sim
