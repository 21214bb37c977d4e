// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"
#include "simulate/integrators.hpp"

#include <Eigen/Core>

namespace twang {

/// Mechanical energy of a body at an instant.
struct BodyEnergy {
  double kinetic_j = 0.0;  ///< ½ vᵀ M v [J]
  double elastic_j = 0.0;  ///< stored in the deformation [J]
  [[nodiscard]] double total_j() const { return kinetic_j + elastic_j; }
};
[[nodiscard]] BodyEnergy measure_energy(const ElasticBody& body, const BodyState& state);

/// Momentum of a body at an instant, about the origin of the mesh's frame.
struct BodyMomentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< sum m v [kg m/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< sum m x × v [kg m²/s]
};
[[nodiscard]] BodyMomentum measure_momentum(const ElasticBody& body, const BodyState& state);

}  // namespace twang
