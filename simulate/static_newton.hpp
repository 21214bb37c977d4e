// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/static_solve.hpp"
#include "fem/stiffness_solver.hpp"

#include <vector>

namespace twang {

/// Static equilibrium as `solve_static` finds it, without a factor: for meshes above what one can
/// hold. Its Newton steps come from MINRES on the matrix-free stiffness, preconditioned by a
/// multigrid cycle turned node by node, and are only as accurate as they need to be; the line
/// search is on the potential energy. A step that would not lower it, where K is indefinite, gives
/// way to the preconditioned gradient. A displacement is prescribed exactly. The load grows in
/// `load_steps` parts, one that fails is halved.
///
/// @param solver  which preconditioner: a stale factor or a multigrid cycle
/// @throws InputError as `solve_static`; Cancelled
[[nodiscard]] StaticResult solve_static_matrix_free(const ElasticBody& body,
                                                    const std::vector<int>& held_nodes,
                                                    const StaticLoad& load,
                                                    const StaticOptions& options = {},
                                                    const StiffnessSolverOptions& solver = {});

}  // namespace twang
