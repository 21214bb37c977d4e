// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"
#include "fem/linear_solver.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <memory>

namespace twang {

/// One multigrid cycle as an approximate inverse of an undeformed body's matrix: symmetric and
/// positive definite to single precision, whatever becomes of the body. For meshes of equal boxes,
/// above what a Cholesky factor can hold.
class MultigridPreconditioner {
 public:
  /// Keeps references to both.
  /// @param max_coarse_dofs  up to which it solves directly
  /// @throws InputError if the mesh is no regular grid
  MultigridPreconditioner(const ElasticBody& body,
                          const FreeDofs& free,
                          int max_coarse_dofs = StiffnessSolverOptions{}.max_coarse_dofs);
  ~MultigridPreconditioner();

  /// Takes the undeformed body's matrix; `stiffness` > 0.
  [[nodiscard]] SolveStatus prepare(const StiffnessCombination& of);
  /// Nearly A⁻¹ r, free degrees of freedom. Not to be called by two threads at once.
  [[nodiscard]] Eigen::VectorXd apply(const Eigen::VectorXd& r) const;
  /// Diagonal of a combination's matrix, undeformed, free degrees of freedom; each entry to some
  /// tenths, the norm to one.
  [[nodiscard]] Eigen::VectorXd estimate_diagonal(const StiffnessCombination& of) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

/// Whether the Automatic choice of StiffnessSolverOptions would be multigrid.
[[nodiscard]] bool prefers_multigrid(const ElasticBody& body,
                                     const FreeDofs& free,
                                     const StiffnessSolverOptions& options = {});

}  // namespace twang
