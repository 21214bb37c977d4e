// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/mapped_block.hpp"

#include "core/error.hpp"
#include "fem/detail/element_geometry.hpp"

#include <fmt/format.h>

namespace twang {
namespace {

/// Steps of half a cell (hex20) or of a cell (hex8), wrapped around closed axes.
class Lattice {
 public:
  Lattice(const MappedBlock& block, ElementKind kind)
      : m_block(block), m_per_cell(kind == ElementKind::Hex20 ? 2 : 1) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      m_size[axis] = m_per_cell * block.cells[axis] + (block.closed[axis] ? 0 : 1);
    }
    m_node.assign(static_cast<std::size_t>(m_size[0]) * static_cast<std::size_t>(m_size[1]) *
                      static_cast<std::size_t>(m_size[2]),
                  -1);
  }

  /// The number of node `a` of a cell; `nodes` gets its place when it is first asked for.
  int node(const std::array<int, 3>& cell, int a, std::vector<Eigen::Vector3d>& nodes) {
    const Eigen::Vector3d xi = reference_node(a);
    std::array<int, 3> step{};
    Eigen::Vector3d s;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<int>(axis);
      const int half_cells = static_cast<int>(xi[i]) + 1;
      step[axis] = m_per_cell * cell[axis] + half_cells * m_per_cell / 2;
      s[i] = static_cast<double>(step[axis]) / (m_per_cell * m_block.cells[axis]);
      if (m_block.closed[axis]) step[axis] %= m_size[axis];
    }
    int& number =
        m_node[static_cast<std::size_t>(step[0]) +
               static_cast<std::size_t>(m_size[0]) *
                   (static_cast<std::size_t>(step[1]) +
                    static_cast<std::size_t>(m_size[1]) * static_cast<std::size_t>(step[2]))];
    if (number < 0) {
      number = static_cast<int>(nodes.size());
      nodes.push_back(m_block.map(s));
    }
    return number;
  }

 private:
  const MappedBlock& m_block;
  int m_per_cell;
  std::array<int, 3> m_size{};
  std::vector<int> m_node;
};

}  // namespace

HexMesh mesh_block(const MappedBlock& block, ElementKind kind) {
  if (!block.map) throw InputError("a block has no map, must have one");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int least = block.closed[axis] ? 3 : 1;
    if (block.cells[axis] >= least) continue;
    throw InputError(fmt::format("a block has {} cells along axis {}, must have {} or more",
                                 block.cells[axis],
                                 axis,
                                 least));
  }
  HexMesh mesh;
  mesh.kind = kind;
  mesh.material_names = {"part"};
  Lattice lattice(block, kind);
  std::vector<Eigen::Vector3d> nodes;
  mesh.elements.resize(nodes_per_element(kind),
                       Eigen::Index{block.cells[0]} * block.cells[1] * block.cells[2]);
  Eigen::Index e = 0;
  for (int k = 0; k < block.cells[2]; ++k) {
    for (int j = 0; j < block.cells[1]; ++j) {
      for (int i = 0; i < block.cells[0]; ++i, ++e) {
        for (int a = 0; a < mesh.elements.rows(); ++a) {
          mesh.elements(a, e) = lattice.node({i, j, k}, a, nodes);
        }
      }
    }
  }
  mesh.nodes.resize(3, static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    mesh.nodes.col(static_cast<Eigen::Index>(n)) = nodes[n];
  }
  mesh.material_of_element.assign(static_cast<std::size_t>(mesh.num_elements()), 0);
  const ElementGeometry check(mesh);  // refuses what is flat or inside out
  mesh.part_volume_m3 = mesh.volume();
  mesh.requested_dx_m = std::cbrt(mesh.part_volume_m3 / mesh.num_elements());
  return mesh;
}

}  // namespace twang
