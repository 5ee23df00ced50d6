// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <queue>
#include <vector>

#include "exposures.hpp"

namespace egomod::sim {

struct Delivery {
  Eye eye = Eye::kLeft;
  bool is_pair = false;     // both cameras' images of the same number and instant
  std::uint64_t index = 0;  // among all that its camera delivers, in order of exposure
  Exposure exposure;

  [[nodiscard]] double arrival_s() const { return exposure.t_s + exposure.late_s; }
};

// What the cameras of a world deliver, one after the other in order of arrival; without end where
// the world has none. Threads: one caller.
class Deliveries {
 public:
  // `world` must outlive this.
  explicit Deliveries(const World& world);
  [[nodiscard]] std::optional<Delivery> next();

 private:
  // The next image of a camera that does not get lost; nothing at the end of the world.
  [[nodiscard]] std::optional<Exposure> following(Eye eye, std::uint64_t number) const;
  [[nodiscard]] Eye earlier() const;
  void expose();

  struct ArrivesLater {
    bool operator()(const Delivery& a, const Delivery& b) const {
      return a.arrival_s() > b.arrival_s();
    }
  };

  const World& world_;
  bool in_pairs_;
  // By eye.
  std::array<std::optional<Exposure>, 2> coming_;
  std::array<std::uint64_t, 2> exposed_{};
  std::priority_queue<Delivery, std::vector<Delivery>, ArrivesLater> under_way_;
};

}  // namespace egomod::sim
