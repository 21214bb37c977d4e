// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/grid_problem.hpp"

#include <memory>
#include <string>

namespace twang {

/// `grid_fault` of a mesh of hex20.
[[nodiscard]] std::string quadratic_grid_fault(const HexMesh& mesh);

/// Of hex20: multigrid by degree. Below the quadratic elements stands the multigrid of the hex8 of
/// the same cells; as trilinear functions are quadratic ones too, whose values in the middle of an
/// edge are the mean of its ends', these are Galerkin's coarse elements exactly [Rønquist & Patera
/// 1987].
[[nodiscard]] std::unique_ptr<GridProblem> make_quadratic_problem(const ElasticBody& body,
                                                                  const FreeDofs& free,
                                                                  int max_coarse_dofs);

}  // namespace twang
