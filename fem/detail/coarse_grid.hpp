// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/cell_grid.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace twang {

/// Cells of a grid by kinds: cells of one kind have the same matrix.
struct TypedGrid {
  CellGrid grid;
  std::vector<char> held;  ///< degrees of freedom, component by component
  Eigen::ArrayXi type;     ///< of each cell
  int num_types = 0;
  std::vector<std::uint32_t> held_of_type;  ///< a bit for each of 24 degrees of freedom

  /// Degrees of freedom that are free.
  [[nodiscard]] int num_free() const;
};

/// Which of a cell's 24 degrees of freedom are held, a bit for each, component by component.
[[nodiscard]] std::uint32_t held_mask(const std::vector<char>& held,
                                      int num_nodes,
                                      const Eigen::Matrix<int, 8, 1>& nodes);

/// Clears rows and columns of a cell's matrix.
void zero_held(std::uint32_t held, Eigen::MatrixXd& matrix);

/// A grid of cells twice as large over a finer one, filled where any of their eight parts is, and
/// the trilinear functions on it.
///
/// The function of a coarse node is what it is on the fine nodes that are free: the coarse operator
/// is that of Galerkin, P' A P, and its cells' matrices are sums over the parts that exist. So a
/// cell that is filled in part, or of several materials, or held at some nodes, is as exact as
/// any. Cells with the same parts share a type.
struct CoarseGrid {
  TypedGrid cells;
  std::vector<std::array<int, 8>> parts_of_type;  ///< types of the finer grid, -1: empty

  Eigen::ArrayXi parents_start;   ///< for each fine node, and one past the last
  Eigen::ArrayXi parents;         ///< coarse nodes; all those of a fine node weigh the same
  Eigen::ArrayXi children_start;  ///< for each coarse node, and one past the last
  Eigen::ArrayXi children;        ///< fine nodes

  explicit CoarseGrid(const TypedGrid& fine);
  /// fine = P coarse, all components; held ones 0.
  void prolong(const TypedGrid& fine, const float* coarse, float* result) const;
  /// coarse = P' fine; held ones 0.
  void restrict_to_coarse(const TypedGrid& fine, const float* residual, float* result) const;
  /// Matrices of the types from those of the finer grid's.
  [[nodiscard]] std::vector<Eigen::MatrixXd> matrices(
      const std::vector<Eigen::MatrixXd>& of_fine) const;
};

}  // namespace twang
