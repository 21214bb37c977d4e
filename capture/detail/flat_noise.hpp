// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/alignment_kernels.hpp"

#include <algorithm>
#include <cmath>

namespace twang::detail {

// Neighbouring residuals' correlation that counts as noise; what goes beyond is misfit, symmetric
// about the marker and so without effect on its place.
inline constexpr double kMostCorrelation = 0.5;

/// Noise of the pixels where neither ink nor paper ends: at the edges, what a template lacks of the
/// lens adds to it without moving the marker. Their mean square, times the factor by which
/// neighbours' correlation widens a mean's variance.
[[nodiscard]] inline double flat_variance(const ResidualSums& sums) {
  const double mean = sums.flat_square / sums.flat;
  const auto widening = [&](double sum, double pairs) {
    const double rho = pairs > 0.0 && mean > 0.0 ? sum / pairs / mean : 0.0;
    // A correlation that its own uncertainty explains counts as none.
    const double bounded = std::clamp(rho - 1.0 / std::sqrt(pairs + 1.0), 0.0, kMostCorrelation);
    return (1.0 + bounded) / (1.0 - bounded);
  };
  return mean * widening(sums.beside, sums.num_beside) * widening(sums.below, sums.num_below);
}

}  // namespace twang::detail
