// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "egomod/core/time.hpp"

namespace egomod {

// Where an object was when it was given up, in axes of the left camera, and how it moved.
struct LostObject {
  std::int64_t id = 0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Nanoseconds last_seen{0};
  bool stopped = false;
};

// Names of objects that have been told no more, for those who come out from behind something, or
// set off again, later than objects coast. Only names: what is named must prove anew that it moves.
class LostObjects {
 public:
  LostObjects();

  void move_on(Nanoseconds now, const Eigen::Isometry3d& T_current_previous);
  // The oldest one makes room.
  void remember(const LostObject& object);
  // The nearest that may have come here at this velocity; null where there is none.
  [[nodiscard]] const LostObject* find(const Eigen::Vector3d& centre_m,
                                       const Eigen::Vector3d& velocity_mps) const;
  void erase(std::int64_t id);

 private:
  [[nodiscard]] bool may_be(const LostObject& object, const Eigen::Vector3d& centre_m,
                            const Eigen::Vector3d& velocity_mps) const;

  Nanoseconds now_{0};
  std::vector<LostObject> objects_;
};

}  // namespace egomod
