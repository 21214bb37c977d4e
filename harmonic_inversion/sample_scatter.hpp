// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <vector>

namespace twang {

/// The median of |x| of a normal distribution, in its standard deviations.
inline constexpr double kMedianOfNormal = 0.6744897501960817;

/// By how much the samples of a channel scatter, their stated standard deviations sigma_i, and what
/// the residual shows beyond them, taken together:
///
///     variance_i = factor² sigma_i² + extra²
///
/// A residual larger than the sigmas say has an `extra`, the same in all samples (a motion that is
/// not quite the model's); one that is smaller has a `factor` below 1, as if the sigmas were known
/// but for their unit. Without stated sigmas `extra` alone is left.
struct SampleScatter {
  double factor = 0.0;  ///< 1 where `extra` is above 0 [-]
  double extra = 0.0;   ///< in the channel's unit

  /// @param sigma  empty: none are stated
  [[nodiscard]] Eigen::VectorXd variances(const Eigen::VectorXd& sigma, Eigen::Index count) const;
};

/// The scatter with which chi² per degree of freedom is 1:
///
///     sum_i r_i² / variance_i = freedom
///
/// @param residual  of the samples that count
/// @param sigma     likewise; empty: none are stated
/// @param freedom   above 0
[[nodiscard]] SampleScatter scatter_by_squares(const Eigen::VectorXd& residual,
                                               const Eigen::VectorXd& sigma,
                                               double freedom);

/// The same by the median of |r_i| / sqrt(variance_i), which a few outliers do not move.
[[nodiscard]] SampleScatter scatter_by_median(const Eigen::VectorXd& residual,
                                              const Eigen::VectorXd& sigma);

}  // namespace twang
