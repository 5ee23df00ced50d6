// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "egomod/core/time.hpp"

namespace egomod {

// Where an object was when it was given up, in axes of the left camera, and how it moved.
struct LostObject {
  std::int64_t id = 0;
  Nanoseconds first_seen{0};
  Nanoseconds last_seen{0};
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  // zero: it had stopped
};

// Names of objects that have been told no more, for those who come out from behind something, or
// set off again, later than objects coast. Only names: what is named must prove anew that it moves.
class LostObjects {
 public:
  LostObjects();

  // Forgets those who may be anywhere by now, and all of them where time steps back.
  void move_on(Nanoseconds now, const Eigen::Isometry3d& T_current_previous);
  // The oldest one makes room.
  void remember(const LostObject& object);
  // The nearest that may have come here at this velocity, and is nobody's yet: from now on it is
  // somebody's.
  [[nodiscard]] std::optional<LostObject> take(const Eigen::Vector3d& centre_m,
                                               const Eigen::Vector3d& velocity_mps);
  void give_back(std::int64_t id);
  void erase(std::int64_t id);
  void clear() { entries_.clear(); }

 private:
  struct Entry {
    LostObject object;
    Nanoseconds lost{0};
    bool is_taken = false;
  };

  [[nodiscard]] bool may_be(const LostObject& object, const Eigen::Vector3d& centre_m,
                            const Eigen::Vector3d& velocity_mps) const;

  Nanoseconds now_{0};
  std::vector<Entry> entries_;
};

}  // namespace egomod
