// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/grid_problem.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <memory>
#include <string>

namespace twang {

/// Conjugate gradients in double precision, each step preconditioned by a multigrid cycle
/// (flexibly, [Notay 2000]: the cycle rounds to single precision).
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

  StiffnessSolverOptions m_options;
  std::string m_reason;
  std::unique_ptr<GridProblem> m_problem;
  LinearMap m_matrix;  ///< empty until prepared
};

}  // namespace twang
