// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace twang {

/// Filled cells of a regular grid and the nodes at their corners. Both are numbered along the
/// grid's first axis, then the second, then the third; so the cells of a row lie side by side, and
/// so do the nodes of each of its four edges.
class CellGrid {
 public:
  /// Consecutive cells along the first axis.
  struct Row {
    int first_cell = 0;
    int length = 0;
    std::array<int, 4> first_node = {};  ///< of the edges at (second, third) = 00, 10, 01, 11
  };
  /// Rows that one thread works on. Slabs of the same parity share no node.
  struct Slab {
    int first_row = 0;
    int last_row = 0;  ///< one past
    int first_node_layer = 0;
    int parity = 0;
  };

  CellGrid() = default;
  /// @param cells  (3 x num_cells), not negative, each once, in any order; kept in the grid's own
  explicit CellGrid(const Eigen::Matrix3Xi& cells);

  [[nodiscard]] int num_cells() const { return static_cast<int>(m_cells.cols()); }
  [[nodiscard]] int num_nodes() const { return static_cast<int>(m_nodes.cols()); }
  [[nodiscard]] const Eigen::Matrix3Xi& cells() const { return m_cells; }
  [[nodiscard]] const Eigen::Matrix3Xi& nodes() const { return m_nodes; }
  [[nodiscard]] const std::vector<Row>& rows() const { return m_rows; }
  [[nodiscard]] const std::vector<Slab>& slabs() const { return m_slabs; }
  /// By bisection; -1 where there is none.
  [[nodiscard]] int find_node(const Eigen::Vector3i& at) const;
  [[nodiscard]] int find_cell(const Eigen::Vector3i& at) const;
  /// The eight nodes of each cell, first axis fastest, (8 x num_cells).
  [[nodiscard]] Eigen::Matrix<int, 8, Eigen::Dynamic> nodes_of_cells() const;

  /// Calls work(row) for every row, on several threads where the grid repays them; sums over cells
  /// come out the same for any number of threads.
  void for_each_row(const std::function<void(const Row& row)>& work) const;

 private:
  Eigen::Matrix3Xi m_cells;
  Eigen::Matrix3Xi m_nodes;
  std::vector<std::int64_t> m_cell_keys;  ///< ascending
  std::vector<std::int64_t> m_node_keys;
  std::int64_t m_stride[2] = {0, 0};
  std::vector<Row> m_rows;
  std::vector<Slab> m_slabs;
  bool m_threaded = false;
};

/// Offsets of the eight corners of a cell, first axis fastest.
[[nodiscard]] inline Eigen::Vector3i corner_offset(int corner) {
  return {corner & 1, (corner >> 1) & 1, (corner >> 2) & 1};
}

}  // namespace twang
