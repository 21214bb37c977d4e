// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"
#include "core/material.hpp"

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// A calibration and what to call it.
struct NamedMaterial {
  std::string name;  ///< of its folder or file
  Material material;
};

/// What one calibration says at its frequency.
struct FrequencyPoint {
  std::string name;
  double frequency_hz = 0.0;
  double youngs_modulus_pa = 0.0;
  double youngs_modulus_sigma_pa = kNaN;  ///< all of its budget [Pa]
  double compared_sigma_pa = kNaN;  ///< the part of it that differs between the calibrations [Pa]
  double tan_delta = 0.0;
  double tan_delta_sigma = kNaN;
  double damping_stiffness_b_s = 0.0;
  double damping_stiffness_b_sigma_s = kNaN;
  int eigenmode = 1;  ///< of its part, from 1
};

/// y = value (f / reference)^exponent, fitted to ln y by weighted least squares.
struct PowerLaw {
  double exponent = 0.0;
  double exponent_sigma = kNaN;  ///< widened where the points scatter more than their sigmas [-]
  double value = 0.0;            ///< at the reference, in the unit of y
  double reference_hz = 0.0;     ///< geometric mean of the frequencies [Hz]
  double chi_square = 0.0;
  int degrees_of_freedom = 0;
  [[nodiscard]] double at(double frequency_hz) const;
};

struct RheologyOptions {
  /// The rigs are one printed piece with other weights or clamps: an error of its dimensions is
  /// then common to all, and takes no part in the comparison.
  bool same_part = false;
};

/// Modulus and loss of one material over frequency.
struct FrequencyDependence {
  std::string material;
  std::vector<FrequencyPoint> points;  ///< ascending in frequency
  std::optional<PowerLaw> modulus;     ///< absent where the frequencies lie too close together
  std::optional<PowerLaw> tan_delta;
  std::optional<PowerLaw> damping;      ///< of b
  double tan_delta_of_exponent = kNaN;  ///< tan(n pi / 2), that of a material with E ~ f^n [-]
  double tan_delta_of_exponent_sigma = kNaN;
  bool changes = false;                ///< E by more than two sigmas of its exponent
  std::vector<std::string> sentences;  ///< what follows, for a person
  std::vector<std::string> notes;      ///< what may make it wrong
};

/// Puts calibrations of one material side by side: does its modulus depend on frequency, and does
/// its loss factor agree with that?
///
/// Compared are the statistical part of E's budget, the repeats, the mesh and the dimensions;
/// density, Poisson's ratio and the clock are taken for common. A material that creeps without a
/// time of its own has E ~ f^n and tan delta = tan(n pi / 2) at all frequencies [Nutting 1921].
/// @throws InputError with fewer than two calibrations, different materials, or one without a
/// frequency
[[nodiscard]] FrequencyDependence frequency_dependence(
    const std::vector<NamedMaterial>& calibrations, const RheologyOptions& options = {});

}  // namespace twang
