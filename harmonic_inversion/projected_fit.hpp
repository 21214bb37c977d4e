// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/damped_pole.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang {

/// The largest exponent of a growing pole; beyond it exp(-d t) is cut, so that its square stays
/// finite.
inline constexpr double kMaxGrowthExponent = 90.0;

/// The weighted linear least-squares fit of one channel for given poles, and what its residual
/// knows of the poles.
///
///     B = [1, t / T, exp(-d t) cos 2 pi f t, exp(-d t) sin 2 pi f t ...],   x = B⁺ y,
///     r = y - B x,   D = d(B x)/d(f1, d1, f2, d2 ...) at fixed x,   J = -(I - B B⁺) D
struct ProjectedFit {
  Eigen::VectorXd coefficients;  ///< x
  Eigen::MatrixXd triangle;      ///< R of B = Q R
  double sum_of_squares = 0.0;   ///< ‖r‖²
  Eigen::MatrixXd inside;        ///< Q^T D
  Eigen::MatrixXd normal;        ///< J^T J
  Eigen::VectorXd gradient;      ///< J^T r
};

/// Column of B in which pole `k` begins.
[[nodiscard]] Eigen::Index column_of_pole(bool fit_drift, std::size_t k);

/// T, by which the drift's column is scaled [s].
[[nodiscard]] double duration_of(const SampleSeries& series);

/// Fits the linear part; the samples are taken in blocks, so that memory does not grow with them.
///
/// @param weights           one a sample, 1 / sigma, or empty
/// @param with_derivatives  whether `inside`, `normal` and `gradient` are wanted
/// Cost: (samples) x (columns)².
[[nodiscard]] ProjectedFit fit_projected(const SampleSeries& series,
                                         const Eigen::VectorXd& weights,
                                         const std::vector<DampedPole>& poles,
                                         bool fit_drift,
                                         bool with_derivatives);

/// The model B x at every sample, unweighted.
[[nodiscard]] Eigen::VectorXd evaluate_model(const SampleSeries& series,
                                             const std::vector<DampedPole>& poles,
                                             bool fit_drift,
                                             const Eigen::VectorXd& coefficients);

/// R of the Cholesky factorization R^T R of a positive semidefinite matrix; pivots lost to
/// round-off are lifted to a trifle of the diagonal.
[[nodiscard]] Eigen::MatrixXd regular_triangle(const Eigen::MatrixXd& normal);

}  // namespace twang
