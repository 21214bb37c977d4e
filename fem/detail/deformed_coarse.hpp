// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/voxel_body.hpp"
#include "fem/linear_solver.hpp"

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <array>
#include <functional>
#include <memory>

namespace twang {

/// Galerkin's coarse problem of any operator on a voxel mesh as it is: of a body, too, that has
/// turned far from where its cells lay.
///
///     Q = P (P' A P)^-1 P'
///
/// P are trilinear functions on a grid so coarse that P' A P can be factorized. Its entries are
/// found by 81 products with A: coarse functions three cells apart do not meet.
class DeformedCoarse {
 public:
  using Operator = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

  DeformedCoarse(const VoxelBody& body, int max_dofs);

  /// NotPositiveDefinite if P' A P is not, and so A is not.
  [[nodiscard]] SolveStatus prepare(const Operator& A);
  /// Q r
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& r) const;
  [[nodiscard]] int num_dofs() const { return m_num_free; }
  [[nodiscard]] double memory_bytes() const;  ///< with the factor, estimated

 private:
  using Functions = Eigen::SparseMatrix<double, Eigen::RowMajor>;

  [[nodiscard]] Eigen::VectorXd prolong(const Eigen::VectorXd& coarse) const;
  [[nodiscard]] Eigen::VectorXd restrict_to_coarse(const Eigen::VectorXd& fine) const;

  std::array<Functions, 3> m_P;  ///< of each component, (nodes x coarse nodes); held ones 0
  /// The node in the direction 0..26 of each coarse node, first axis fastest, -1 where none is.
  Eigen::Array<int, 27, Eigen::Dynamic> m_neighbours;
  Eigen::ArrayXi m_colour;        ///< of each coarse node, 0..26
  Eigen::Matrix3Xi m_free_index;  ///< of each coarse degree of freedom, -1 where held
  int m_num_free = 0;
  std::unique_ptr<LinearSolver> m_solver;
};

}  // namespace twang
