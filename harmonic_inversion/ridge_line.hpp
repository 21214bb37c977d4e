// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace twang {

/// The slope of a straight line and its standard deviation.
struct RidgeLine {
  double mean_x = 0.0;
  double mean = 0.0;  ///< y at mean_x
  double slope = 0.0;
  double slope_sigma = 0.0;
  [[nodiscard]] double at(double x) const { return mean + slope * (x - mean_x); }
};

/// Least squares through correlated points, each weighted by its own variance:
///
///     slope = q^T y,   sigma² = q^T C q max(1, s / E[s]),   s = sum of weighted squares that
///     remain
///
/// so that points which scatter more than their covariance C says widen the sigma.
[[nodiscard]] RidgeLine fit_ridge_line(const Eigen::VectorXd& x,
                                       const Eigen::VectorXd& y,
                                       const Eigen::MatrixXd& covariance);

/// The same through independent points, whose variances are given: C is their diagonal matrix.
/// @return  cost and memory grow with the number of points, not with its square
[[nodiscard]] RidgeLine fit_ridge_line_through_independent(const Eigen::VectorXd& x,
                                                           const Eigen::VectorXd& y,
                                                           const Eigen::VectorXd& variance);

}  // namespace twang
