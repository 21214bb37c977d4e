// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/deformed_coarse.hpp"
#include "fem/detail/grid_problem.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <memory>
#include <string>

namespace twang {

/// Conjugate gradients in double precision, each step preconditioned by a multigrid cycle
/// (flexibly, [Notay 2000]: the cycle rounds to single precision).
///
/// The cycle C knows the undeformed body alone. Where that is not good enough a coarse problem Q of
/// the body as it is joins it, by balancing [Mandel 1993]:
///
///     z = Q r + (1 - Q A) C (1 - A Q) r
class MultigridSolver final : public StiffnessSolver {
 public:
  MultigridSolver(const ElasticBody& body,
                  const FreeDofs& free,
                  const StiffnessSolverOptions& options,
                  std::string reason);

  SolveStatus prepare(const StiffnessCombination& of, const Eigen::VectorXd& u) override;
  StiffnessSolution solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) override;
  [[nodiscard]] StiffnessSolverKind kind() const override { return StiffnessSolverKind::Multigrid; }
  [[nodiscard]] std::string description() const override;
  [[nodiscard]] double memory_bytes() const override;

 private:
  [[nodiscard]] StiffnessSolution solve_one(const Eigen::VectorXd& b, Eigen::VectorXd& x);
  [[nodiscard]] Eigen::VectorXd precondition(const Eigen::VectorXd& r);
  /// Makes Q for the operator as it is.
  [[nodiscard]] SolveStatus balance();

  StiffnessSolverOptions m_options;
  std::string m_reason;
  std::unique_ptr<GridProblem> m_problem;
  LinearMap m_matrix;  ///< empty until prepared
  bool m_deformed = false;
  std::unique_ptr<DeformedCoarse> m_deformed_coarse;  ///< once it has been needed
  bool m_balanced = false;                            ///< whether it is that of the matrix
};

}  // namespace twang
