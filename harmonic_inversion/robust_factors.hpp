// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace twang {

/// The part of its weight that each sample keeps in a fit that outliers, alone or in a short run (a
/// marker that jumps for some frames), must not move; iterated, a loss that is square up to c and
/// constant beyond 2 c.
///
///     factor = 1                       |z| <= c
///            = 1 - ((|z| - c) / c)²    c < |z| < 2 c
///            = 0                       beyond,          c = max(4, sqrt(2 ln 10 n))
///
/// z is the residual over its robust scatter, that of all samples or of the neighbours in time,
/// whichever is larger: where the model itself is a little wrong, it is wrong for all of them. In
/// normal noise one record in ten has a sample beyond c at the most.
///
/// @param residual  in units of the samples' sigmas, in order of time
/// @return          all 1 if so many are far off that it is the model that is wrong
[[nodiscard]] Eigen::VectorXd robust_factors(const Eigen::VectorXd& residual);

}  // namespace twang
