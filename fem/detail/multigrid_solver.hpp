// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/deformed_coarse.hpp"
#include "fem/detail/multigrid.hpp"
#include "fem/detail/voxel_body.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <memory>
#include <string>

namespace twang {

/// A x in double precision, matrix-free, on vectors of a VoxelBody: its own cells undeformed, the
/// body's element kernels at any other displacement. There hex8e, whose internal modes would have
/// to be found in every product, is assembled.
class VoxelOperator {
 public:
  /// Keeps references to all but `of`.
  VoxelOperator(const ElasticBody& body,
                const VoxelBody& voxels,
                const StiffnessCombination& of,
                const Eigen::VectorXd& u);
  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& x) const;
  [[nodiscard]] bool deformed() const { return m_u.size() > 0; }
  [[nodiscard]] double memory_bytes() const;  ///< of what is assembled

 private:
  const ElasticBody& m_body;
  const VoxelBody& m_voxels;
  StiffnessCombination m_of;
  Eigen::VectorXd m_u;    ///< empty: undeformed
  SparseMatrix m_matrix;  ///< stiffness and damping at u, if assembled
  CellModuli<double> m_moduli;
};

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

  const ElasticBody& m_body;
  StiffnessSolverOptions m_options;
  std::string m_reason;
  VoxelBody m_voxels;
  Multigrid m_multigrid;
  std::unique_ptr<VoxelOperator> m_operator;
  std::unique_ptr<DeformedCoarse> m_deformed_coarse;  ///< once it has been needed
  bool m_balanced = false;                            ///< whether it is that of the operator
};

}  // namespace twang
