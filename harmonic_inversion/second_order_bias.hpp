// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/refine_sinusoids.hpp"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace twang {

/// By how much the model of a fit, its parameters scattering by their covariance, lies above itself
/// on average, one a channel and sample:
///
///     h(t) = 1/2 sum_ab cov_ab d²y(t) / dtheta_a dtheta_b
///          = sum_k Re[(1/2 z_k E[δs_k²] t² + E[δz_k δs_k] t) exp(s_k t)],
///     z = a - i b,   s = -d + i 2 pi f
[[nodiscard]] std::vector<Eigen::VectorXd> mean_excess(const std::vector<SampleSeries>& series,
                                                       const SinusoidFit& fit);

/// The fit without its bias of second order, -(J^T J)^-1 J^T h in all parameters [Box 1971]: least
/// squares of the data with h added to them. Sums of squares stay those of `fit`, residuals are
/// left out.
///
/// Nothing where that makes no difference, and where a theory of second order does not hold: h is
/// as large as the scatter of the model itself, a pole would move by more than its sigma or turn
/// from decay to growth.
///
/// @param fit      least squares of `series`
/// @param weights  one a channel and sample, by which it was fitted
/// @param options  by which it was fitted, `records` aside
[[nodiscard]] std::optional<SinusoidFit> without_bias(const std::vector<SampleSeries>& series,
                                                      const SinusoidFit& fit,
                                                      const std::vector<Eigen::VectorXd>& weights,
                                                      RefineOptions options);

}  // namespace twang
