// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"
#include "fem/linear_solver.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace twang {

/// A x, matrix-free.
using LinearMap = std::function<Eigen::VectorXd(const Eigen::VectorXd& x)>;

/// A body whose elements are cells of a regular grid, of hex8, hex8e or hex20: products with its
/// matrices, and a multigrid cycle that nearly inverts them. Vectors are (size()), every degree of
/// freedom of the mesh in an order of the problem's own; held ones are 0.
class GridProblem {
 public:
  virtual ~GridProblem() = default;
  [[nodiscard]] int size() const { return static_cast<int>(held().size()); }
  [[nodiscard]] virtual const std::vector<char>& held() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd from_free(const Eigen::VectorXd& free) const = 0;
  [[nodiscard]] virtual Eigen::VectorXd to_free(const Eigen::VectorXd& own) const = 0;
  [[nodiscard]] virtual Eigen::VectorXd from_full(const Eigen::VectorXd& full) const = 0;
  [[nodiscard]] virtual Eigen::VectorXd to_full(const Eigen::VectorXd& own) const = 0;

  /// Products with A at displacement u (3 num_nodes; empty: undeformed) in double precision, point
  /// masses included. Keeps references to the problem and the body.
  [[nodiscard]] virtual LinearMap matrix(const StiffnessCombination& of,
                                         const Eigen::VectorXd& u) const = 0;

  /// Takes a new A, undeformed, for the cycle. NotPositiveDefinite if the coarsest level or a block
  /// of a diagonal is not.
  [[nodiscard]] virtual SolveStatus prepare(const StiffnessCombination& of) = 0;
  /// One cycle from zero: nearly A^-1 r, symmetric and positive definite where A is. Not to be
  /// called by two threads at once.
  [[nodiscard]] virtual Eigen::VectorXd cycle(const Eigen::VectorXd& r) = 0;

  /// Of the coarsest level: Galerkin's matrix on its free degrees of freedom, (n x n), A^-1 b there
  /// after `prepare`, and a function there as a vector of the finest.
  [[nodiscard]] virtual SparseMatrix coarsest_matrix(const StiffnessCombination& of) const = 0;
  [[nodiscard]] virtual Eigen::VectorXd solve_coarsest(const Eigen::VectorXd& b) = 0;
  [[nodiscard]] virtual Eigen::VectorXd prolong_from_coarsest(const Eigen::VectorXd& x) = 0;
  [[nodiscard]] virtual int coarsest_dofs() const = 0;
  [[nodiscard]] virtual int num_levels() const = 0;
  [[nodiscard]] virtual double memory_bytes() const = 0;  ///< estimated
};

/// What keeps a mesh from being treated as cells of a regular grid, in a few words; empty if
/// nothing does.
[[nodiscard]] std::string grid_fault(const HexMesh& mesh);

/// Keeps references to both.
/// @param body  without grid_fault
[[nodiscard]] std::unique_ptr<GridProblem> make_grid_problem(const ElasticBody& body,
                                                             const FreeDofs& free,
                                                             int max_coarse_dofs);

}  // namespace twang
