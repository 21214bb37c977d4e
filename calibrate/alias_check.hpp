// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/damped_sinusoid.hpp"

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// What is asked whether the samples were too few a second.
struct AliasQuestion {
  std::vector<DampedSinusoid> modes;  ///< of the signal, strongest first
  double rate_hz = 0.0;               ///< samples a second [Hz]
  std::vector<double>
      mesh_hz;  ///< natural frequencies of the mesh, scaled to the strongest sinusoid [Hz]
  std::optional<double> expected_hz;  ///< the strongest sinusoid's mode with the modulus that the
                                      ///< maker or the literature reports [Hz]
  int mode = 0;                       ///< of the mesh that the strongest sinusoid is, from 0
};

/// Where a frequency appears after sampling: the nearest of |f - n rate|, 0 to rate / 2 [Hz].
[[nodiscard]] double folded_hz(double frequency_hz, double rate_hz);

/// Warnings, one sentence each, naming the twins:
///
/// - the strongest sinusoid, if one of its twins (n rate ± f) is nearer to the expected
///   frequency than itself and close to it;
/// - the strongest sinusoid, if with its twin in its place the mesh puts a
/// further
///   sinusoid of the signal where it is (folded), and does not as things stand;
/// - any sinusoid on which a natural frequency of the mesh above half the rate folds.
[[nodiscard]] std::vector<std::string> alias_warnings(const AliasQuestion& question);

}  // namespace twang
