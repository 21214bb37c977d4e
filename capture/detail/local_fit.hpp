// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace twang::detail {

inline constexpr int kMostSamples = 24;  // for a fit: three times its terms
inline constexpr int kMostTerms = 7;

/// A path around a frame.
struct Samples {
  std::vector<double> t;  // from the frame in question [frames]
  std::vector<double> y;  // [px], or grey levels
};

// Sizes are bounded: a fit takes no memory of its own.
using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostTerms, 1>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostTerms, kMostTerms>;

/// A vibration of slowly changing size and phase about a slowly moving rest, or a cubic, fitted to
/// the samples about a frame.
struct LocalFit {
  double omega = 0.0;  // [rad/frame]; 0: cubic
  Coefficients coefficients;
  Square covariance;  // over the squared residual
  double residual = kNaN;
  static constexpr int kMostDropped = 3;  // where repeats may be among the samples

  struct Expected {
    double at;
    double error;  // of a sample there, one sigma
  };
  [[nodiscard]] Expected at(double t) const;
};

/// The fit of the frequency that suits best, the smooth one where none does better; nothing where
/// samples are too few.
/// @param floor         least standard deviation of a sample
/// @param most_dropped  of samples that the others' fit leaves far out
[[nodiscard]] std::optional<LocalFit> best_fit(const Samples& samples,
                                               double floor,
                                               int most_dropped = 0);

}  // namespace twang::detail
