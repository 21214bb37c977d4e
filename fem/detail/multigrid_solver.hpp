// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/multigrid.hpp"
#include "fem/detail/voxel_body.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <string>

namespace twang {

/// A x in double precision, matrix-free, on vectors of a VoxelBody: its own cells undeformed, the
/// body's element kernels at any other displacement.
class VoxelOperator {
 public:
  /// Keeps references to all but `of`.
  VoxelOperator(const ElasticBody& body,
                const VoxelBody& voxels,
                const StiffnessCombination& of,
                const Eigen::VectorXd& u);
  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& x) const;

 private:
  const ElasticBody& m_body;
  const VoxelBody& m_voxels;
  StiffnessCombination m_of;
  Eigen::VectorXd m_u;  ///< empty: undeformed
  CellModuli<double> m_moduli;
};

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

  const ElasticBody& m_body;
  StiffnessSolverOptions m_options;
  std::string m_reason;
  VoxelBody m_voxels;
  Multigrid m_multigrid;
  std::unique_ptr<VoxelOperator> m_operator;
};

}  // namespace twang
