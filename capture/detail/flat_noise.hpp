// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

namespace twang::detail {

// Neighbouring residuals' correlation that counts as noise; what goes beyond is misfit, symmetric
// about the marker and so without effect on its place.
inline constexpr double kMostCorrelation = 0.5;

/// Noise of the pixels where neither ink nor paper ends: at the edges, what a template lacks of the
/// lens adds to it without moving the marker.
struct FlatNoise {
  double square = 0.0, count = 0.0;
  double beside = 0.0, num_beside = 0.0;
  double below = 0.0, num_below = 0.0;

  void add(double residual, double left, double above) {
    square += residual * residual, count += 1.0;
    if (!std::isnan(left)) beside += residual * left, num_beside += 1.0;
    if (!std::isnan(above)) below += residual * above, num_below += 1.0;
  }
  /// Mean square, times the factor by which neighbours' correlation widens a mean's variance.
  [[nodiscard]] double variance() const {
    const auto widening = [&](double sum, double pairs) {
      const double rho = pairs > 0.0 && square > 0.0 ? sum / pairs / (square / count) : 0.0;
      // A correlation that its own uncertainty explains counts as none.
      const double bounded = std::clamp(rho - 1.0 / std::sqrt(pairs + 1.0), 0.0, kMostCorrelation);
      return (1.0 + bounded) / (1.0 - bounded);
    };
    return square / count * widening(beside, num_beside) * widening(below, num_below);
  }
};

}  // namespace twang::detail
