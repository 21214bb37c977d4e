// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/node_graph.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace twang {
namespace {

/// For every node the elements that have it, as offsets and one list.
struct ElementsOfNodes {
  std::vector<int> start;
  std::vector<int> elements;
};

ElementsOfNodes elements_of_nodes(const HexMesh& mesh) {
  ElementsOfNodes result;
  result.start.assign(static_cast<std::size_t>(mesh.num_nodes()) + 1, 0);
  for (const int node : mesh.elements.reshaped())
    ++result.start[static_cast<std::size_t>(node) + 1];
  for (std::size_t n = 1; n < result.start.size(); ++n) result.start[n] += result.start[n - 1];
  std::vector<int> next(result.start.begin(), result.start.end() - 1);
  result.elements.resize(static_cast<std::size_t>(mesh.elements.size()));
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (int a = 0; a < mesh.elements.rows(); ++a) {
      int& place = next[static_cast<std::size_t>(mesh.elements(a, e))];
      result.elements[static_cast<std::size_t>(place++)] = e;
    }
  }
  return result;
}

}  // namespace

NodeGraph::NodeGraph(const HexMesh& mesh)
    : m_nodes_per_element(static_cast<int>(mesh.elements.rows())) {
  const ElementsOfNodes incident = elements_of_nodes(mesh);
  std::vector<int> place_of_node(static_cast<std::size_t>(mesh.num_nodes()), -1);
  const auto per_element = static_cast<std::size_t>(m_nodes_per_element);
  m_rank.resize(static_cast<std::size_t>(mesh.num_elements()) * per_element * per_element);
  m_start.push_back(0);
  std::vector<int> around;
  for (int b = 0; b < mesh.num_nodes(); ++b) {
    const int first = incident.start[static_cast<std::size_t>(b)];
    const int last = incident.start[static_cast<std::size_t>(b) + 1];
    around.clear();
    for (int i = first; i < last; ++i) {
      const int e = incident.elements[static_cast<std::size_t>(i)];
      for (int a = 0; a < m_nodes_per_element; ++a) {
        const int node = mesh.elements(a, e);
        int& place = place_of_node[static_cast<std::size_t>(node)];
        if (place < 0) around.push_back(node);
        place = 0;
      }
    }
    std::sort(around.begin(), around.end());
    for (std::size_t i = 0; i < around.size(); ++i) {
      place_of_node[static_cast<std::size_t>(around[i])] = static_cast<int>(i);
    }
    for (int i = first; i < last; ++i) {
      const int e = incident.elements[static_cast<std::size_t>(i)];
      const auto column = static_cast<std::size_t>(
          std::find(mesh.elements.col(e).begin(), mesh.elements.col(e).end(), b) -
          mesh.elements.col(e).begin());
      for (std::size_t a = 0; a < per_element; ++a) {
        const auto node = static_cast<std::size_t>(mesh.elements(static_cast<Eigen::Index>(a), e));
        m_rank[(static_cast<std::size_t>(e) * per_element + column) * per_element + a] =
            static_cast<std::uint16_t>(place_of_node[node]);
      }
    }
    for (const int node : around) place_of_node[static_cast<std::size_t>(node)] = -1;
    m_neighbours.insert(m_neighbours.end(), around.begin(), around.end());
    if (m_neighbours.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()) / 9) {
      throw InputError(fmt::format(
          "a mesh of {} nodes is too large for an assembled stiffness matrix; dx must be larger",
          mesh.num_nodes()));
    }
    m_start.push_back(static_cast<int>(m_neighbours.size()));
  }
}

int NodeGraph::find(int row_node, int column_node) const {
  const auto first = m_neighbours.begin() + start(column_node);
  const auto last = m_neighbours.begin() + start(column_node + 1);
  const auto at = std::lower_bound(first, last, row_node);
  return at != last && *at == row_node ? static_cast<int>(at - first) : -1;
}

SparseMatrix NodeGraph::stiffness_pattern() const {
  const int num_dofs = 3 * num_nodes();
  SparseMatrix K(num_dofs, num_dofs);
  K.resizeNonZeros(9 * static_cast<Eigen::Index>(m_neighbours.size()));
  int* outer = K.outerIndexPtr();
  int* inner = K.innerIndexPtr();
  for (int b = 0; b < num_nodes(); ++b) {
    for (int column = 0; column < 3; ++column) {
      outer[3 * b + column] = column_start(b, column);
      for (int i = start(b); i < start(b + 1); ++i) {
        const int row = 3 * m_neighbours[static_cast<std::size_t>(i)];
        *inner++ = row;
        *inner++ = row + 1;
        *inner++ = row + 2;
      }
    }
  }
  outer[num_dofs] = 9 * start(num_nodes());
  return K;
}

SparseMatrix NodeGraph::diagonal_blocks(const std::vector<double>& value) const {
  const int num_dofs = 3 * num_nodes();
  SparseMatrix M(num_dofs, num_dofs);
  M.resizeNonZeros(3 * static_cast<Eigen::Index>(m_neighbours.size()));
  int next = 0;
  for (int b = 0; b < num_nodes(); ++b) {
    for (int column = 0; column < 3; ++column) {
      M.outerIndexPtr()[3 * b + column] = next;
      for (int i = start(b); i < start(b + 1); ++i) {
        const auto at = static_cast<std::size_t>(i);
        M.innerIndexPtr()[next] = 3 * m_neighbours[at] + column;
        M.valuePtr()[next++] = value[at];
      }
    }
  }
  M.outerIndexPtr()[num_dofs] = next;
  return M;
}

}  // namespace twang
