// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"
#include "core/material.hpp"

namespace twang::detail {

/// The material with which steps of the trapezoidal rule move as `material` does.
///
/// The rule makes of an eigenvalue z of the motion z + z³ h² / 12: with e = (omega h)² / 12 periods
/// longer by e and decays slower by 3 e. What is stiffer by 2 e and more damped by e undoes it, up
/// to e².
/// @param steps_per_period  2 pi / (omega h)
[[nodiscard]] inline ElasticMaterial without_step_error(ElasticMaterial material,
                                                        double steps_per_period) {
  const double omega_h = kTwoPi / steps_per_period;
  const double e = omega_h * omega_h / 12.0;
  material.youngs_modulus_pa *= 1.0 + 2.0 * e;
  material.damping_stiffness_b_s *= 1.0 + e;
  return material;
}

}  // namespace twang::detail
