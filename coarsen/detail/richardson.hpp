// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"

#include <vector>

namespace twang {

/// The limit of eigenvalues on meshes that halve dx from one to the next [Richardson 1911].
///
///     lambda(dx) = limit + C dx^p,   2^p = (l1 - l2) / (l2 - l3)
///     limit = l3 - (l2 - l3) / (2^p - 1)
///
/// The order p is observed on the last three where it is plausible, otherwise assumed. Sigma is
/// half the correction from the finest mesh to the limit with an observed order, the whole
/// correction with an assumed one, the whole last change if the changes do not shrink, and a
/// generous constant with one mesh alone; it has a floor.
///
/// @param lambdas_per_s2  coarse to fine, at least one [1/s²]
[[nodiscard]] RichardsonLimit richardson_limit(const std::vector<double>& lambdas_per_s2);

}  // namespace twang
