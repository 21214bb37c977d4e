// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/chebyshev_smoother.hpp"
#include "fem/detail/coarse_grid.hpp"
#include "fem/detail/voxel_body.hpp"
#include "fem/linear_solver.hpp"

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace twang {

/// A V-cycle of geometric multigrid on a voxel mesh, in single precision: an approximate A^-1,
/// symmetric and positive definite where A is.
///
/// The finest level multiplies without a matrix; each coarser one has cells twice as large, with
/// Galerkin's matrices; the coarsest is solved directly.
class Multigrid {
 public:
  /// Keeps a reference to `body`.
  Multigrid(const VoxelBody& body, int max_coarse_dofs);

  /// Takes a new A, undeformed. NotPositiveDefinite if the coarsest level or a block of a diagonal
  /// is not.
  [[nodiscard]] SolveStatus prepare(const StiffnessCombination& of);
  /// One cycle from zero: nearly A^-1 r. Not to be called by two threads at once.
  [[nodiscard]] Eigen::VectorXd cycle(const Eigen::VectorXd& r);

  /// Of the coarsest level: Galerkin's matrix on its free degrees of freedom, (n x n), A^-1 b there
  /// after `prepare`, and a function there as a vector of the finest.
  [[nodiscard]] SparseMatrix coarsest_matrix(const StiffnessCombination& of) const;
  [[nodiscard]] Eigen::VectorXd solve_coarsest(const Eigen::VectorXd& b);
  [[nodiscard]] Eigen::VectorXd prolong_from_coarsest(const Eigen::VectorXd& x);

  [[nodiscard]] int num_levels() const { return static_cast<int>(m_levels.size()); }
  [[nodiscard]] int coarsest_dofs() const { return m_num_coarsest; }
  [[nodiscard]] double memory_bytes() const;

 private:
  struct Level {
    const TypedGrid* cells = nullptr;
    std::vector<float> matrices;  ///< (24 x 24) of each type, coarse levels alone
    std::unique_ptr<ChebyshevSmoother> smoother;

    [[nodiscard]] int num_nodes() const { return cells->grid.num_nodes(); }
  };
  void add_product(const Level& level, float scale, const float* x, float* y) const;
  [[nodiscard]] static Eigen::ArrayXXd diagonal_blocks(
      const Level& level, const std::vector<Eigen::MatrixXd>& matrices);
  [[nodiscard]] ChebyshevSmoother::Product product_of(const Level& level) const;
  void cycle_from(std::size_t index);
  [[nodiscard]] std::vector<Eigen::MatrixXd> fine_matrices(const StiffnessCombination& of) const;
  [[nodiscard]] SparseMatrix assemble_coarsest(const std::vector<Eigen::MatrixXd>& matrices) const;
  void cycle_coarsest(Level& level);
  void set_coarsest(const Eigen::VectorXd& x);

  const VoxelBody& m_body;
  std::vector<int> m_type_of_fine;  ///< the body's, of each type of m_fine
  TypedGrid m_fine;
  std::vector<std::unique_ptr<CoarseGrid>> m_coarse;
  std::vector<Level> m_levels;
  CellModuli<float> m_moduli;
  std::vector<int> m_coarsest_free;  ///< free index of each degree of freedom, -1 where held
  int m_num_coarsest = 0;
  std::unique_ptr<LinearSolver> m_solver;
};

}  // namespace twang
