// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace twang {

/// Which nodes share an element: the pattern of all matrices of a mesh, in blocks of 3 x 3.
class NodeGraph {
 public:
  /// @throws InputError if a stiffness matrix would have more than 2^31 entries
  explicit NodeGraph(const HexMesh& mesh);

  [[nodiscard]] int num_nodes() const { return static_cast<int>(m_start.size()) - 1; }
  /// First place of a node's neighbours in `neighbours`; itself among them, ascending.
  [[nodiscard]] int start(int node) const { return m_start[static_cast<std::size_t>(node)]; }
  [[nodiscard]] int degree(int node) const { return start(node + 1) - start(node); }
  [[nodiscard]] const std::vector<int>& neighbours() const { return m_neighbours; }
  /// Place of node a of an element among the neighbours of its node b.
  [[nodiscard]] int rank(int element, int a, int b) const {
    const auto n = static_cast<std::size_t>(m_nodes_per_element);
    return m_rank[(static_cast<std::size_t>(element) * n + static_cast<std::size_t>(b)) * n +
                  static_cast<std::size_t>(a)];
  }
  /// Where the first entry of column 3 `node` + `column` stands among a stiffness matrix's values.
  [[nodiscard]] int column_start(int node, int column) const {
    return 9 * start(node) + 3 * column * degree(node);
  }
  /// Place of `row_node` among the neighbours of `column_node`, by bisection; -1 if it is none.
  [[nodiscard]] int find(int row_node, int column_node) const;

  /// All of a stiffness matrix but its values, which are left unset.
  [[nodiscard]] SparseMatrix stiffness_pattern() const;
  /// A matrix with `value` (one for each entry of `neighbours`) times the 3 x 3 identity in each
  /// block.
  [[nodiscard]] SparseMatrix diagonal_blocks(const std::vector<double>& value) const;

 private:
  int m_nodes_per_element = 0;
  std::vector<int> m_start;
  std::vector<int> m_neighbours;
  std::vector<std::uint16_t> m_rank;
};

}  // namespace twang
