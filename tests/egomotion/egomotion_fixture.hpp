// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <ostream>
#include <string>

#include "egomod/egomotion/egomotion_estimator.hpp"
#include "synthetic_tracks.hpp"

namespace egomod {

struct Variant {
  EgomotionMethod method;
  bool map;
};

// Both estimators, against the map and frame to frame.
class EgomotionTest : public testing::TestWithParam<Variant> {
 protected:
  [[nodiscard]] EgomotionConfig config() const {
    EgomotionConfig config;
    config.method = GetParam().method;
    config.map = GetParam().map;
    return config;
  }
};

inline Vector6d error_of(const Egomotion& motion, const Eigen::Isometry3d& truth) {
  return se3_log(motion.T_previous_current.inverse() * truth);
}

inline Eigen::Isometry3d forward_and_left() {
  Vector6d xi;
  xi << 0.01, 0.0, 0.12, 0.0, -0.02, 0.0;
  return se3_exp(xi);
}

inline auto all_variants() {
  return testing::Values(Variant{EgomotionMethod::kGaussNewton, false},
                         Variant{EgomotionMethod::kGaussNewton, true},
                         Variant{EgomotionMethod::kSigmaPointKalmanFilter, false},
                         Variant{EgomotionMethod::kSigmaPointKalmanFilter, true});
}

inline std::string name_of(const Variant& variant) {
  const bool is_gauss_newton = variant.method == EgomotionMethod::kGaussNewton;
  return std::string(is_gauss_newton ? "GaussNewton" : "SigmaPoint") +
         (variant.map ? "Map" : "FrameToFrame");
}

inline std::string variant_name(const testing::TestParamInfo<Variant>& variant) {
  return name_of(variant.param);
}

// Else GoogleTest prints bytes.
inline void PrintTo(const Variant& variant, std::ostream* out) { *out << name_of(variant); }

}  // namespace egomod
