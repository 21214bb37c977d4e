// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "core/units.hpp"
#include "fem/detail/voxel_grid.hpp"
#include "fem/hex_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace twang {
namespace {

/// Grids tried in search of a dx that would do stay below this, to answer within a second.
constexpr double kMaxTrialCells = 1e6;
constexpr int kMaxTrials = 8;

using Kind = VoxelFault::Kind;

double trial_cells(const Rig& rig, double dx_m) {
  const Box bounds = rig.bounding_box();
  double cells = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    cells *= cells_along(bounds.max[axis] - bounds.min[axis], dx_m);
  }
  return cells;
}

/// The first of thickness, thickness / 2, ... of the solid at fault (or of dx / 2, dx / 4, ... if
/// it is thicker than that) at which nothing is wrong with the grid.
std::optional<double> find_dx_that_works(const Rig& rig, double dx_m, const VoxelFault& fault) {
  const Box bounds = bounds_of(rig.parts[static_cast<std::size_t>(fault.solid)]);
  const double thickness = (bounds.max - bounds.min).minCoeff();
  double trial = thickness > 0.0 ? std::min(thickness, 0.5 * dx_m) : 0.5 * dx_m;
  for (int k = 0; k < kMaxTrials && trial_cells(rig, trial) <= kMaxTrialCells; ++k) {
    if (find_fault(rig, fill_voxels(rig, trial)).kind == Kind::None) return trial;
    trial *= 0.5;
  }
  return std::nullopt;
}

std::string describe(const Rig& rig, int solid_index) {
  const PartSolid& solid = rig.parts[static_cast<std::size_t>(solid_index)];
  const char* shape = std::holds_alternative<Box>(solid.shape) ? "box" : "cylinder";
  return fmt::format("{}: part {} of {} ({}, material \"{}\")",
                     rig.file.empty() ? rig.name : rig.file.string(),
                     solid_index + 1,
                     rig.parts.size(),
                     shape,
                     solid.material);
}

/// @throws InputError unless the grid is whole, or lacks no more than a solid under later ones
void check_grid(const Rig& rig, const VoxelGrid& grid, double dx_m) {
  const VoxelFault fault = find_fault(rig, grid);
  if (fault.kind == Kind::None) return;
  const std::optional<double> works = find_dx_that_works(rig, dx_m, fault);
  if (fault.kind == Kind::Covered && !works) return;
  const std::string reason =
      fault.kind == Kind::Disconnected ? "is not connected by faces with the rest of the part"
      : fault.kind == Kind::Covered    ? "vanishes under later ones, no cell of it is left"
                                       : "vanishes, no cell has its centre in it";
  const std::string advice =
      works ? fmt::format("dx must be smaller, {:.6g} mm would do", *works * kMillimetresPerMetre)
            : std::string("dx must be much smaller, or the part mended");
  throw InputError(fmt::format("{} {} at dx = {:.6g} mm; {}",
                               describe(rig, fault.solid),
                               reason,
                               dx_m * kMillimetresPerMetre,
                               advice));
}

/// Numbers the nodes of the filled cells on the grid of half cells.
class NodeNumbering {
 public:
  NodeNumbering(const VoxelGrid& grid, ElementKind kind) : m_grid(grid), m_kind(kind) {
    std::array<std::size_t, 3> axes = {0, 1, 2};
    std::stable_sort(axes.begin(), axes.end(), [&](std::size_t a, std::size_t b) {
      return grid.count[a] < grid.count[b];
    });
    std::size_t stride = 1;
    for (const std::size_t axis : axes) {
      m_stride[axis] = stride;
      stride *= static_cast<std::size_t>(points_per_cell() * grid.count[axis] + 1);
    }
    m_node_at.assign(stride, -1);
    m_axes = axes;
  }

  /// Lattice place of a node of cell (i, j, k), in lattice steps from the grid's origin.
  [[nodiscard]] std::array<int, 3> lattice(const std::array<int, 3>& cell, int node) const {
    const Eigen::Vector3d xi = reference_node(node);
    std::array<int, 3> place{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int half_steps = static_cast<int>(xi[static_cast<int>(axis)]) + 1;
      place[axis] = points_per_cell() * cell[axis] + half_steps * points_per_cell() / 2;
    }
    return place;
  }
  int& node_at(const std::array<int, 3>& place) {
    return m_node_at[static_cast<std::size_t>(place[0]) * m_stride[0] +
                     static_cast<std::size_t>(place[1]) * m_stride[1] +
                     static_cast<std::size_t>(place[2]) * m_stride[2]];
  }

  /// Gives every marked place a number, lattice order, and its position.
  Eigen::Matrix3Xd number_marked() {
    const auto marked = std::count(m_node_at.begin(), m_node_at.end(), 0);
    Eigen::Matrix3Xd nodes(3, marked);
    int next = 0;
    for (std::size_t at = 0; at < m_node_at.size(); ++at) {
      if (m_node_at[at] != 0) continue;
      nodes.col(next) = position(at);
      m_node_at[at] = next++;
    }
    return nodes;
  }

 private:
  [[nodiscard]] int points_per_cell() const { return m_kind == ElementKind::Hex20 ? 2 : 1; }

  [[nodiscard]] Eigen::Vector3d position(std::size_t at) const {
    Eigen::Vector3d x = m_grid.origin;
    for (int level = 2; level >= 0; --level) {
      const std::size_t axis = m_axes[static_cast<std::size_t>(level)];
      const auto step = static_cast<double>(at / m_stride[axis]) / points_per_cell();
      at %= m_stride[axis];
      x[static_cast<int>(axis)] += step * m_grid.cell[static_cast<int>(axis)];
    }
    return x;
  }

  const VoxelGrid& m_grid;
  ElementKind m_kind;
  std::array<std::size_t, 3> m_axes{};    ///< fewest cells first
  std::array<std::size_t, 3> m_stride{};  ///< by axis
  std::vector<int> m_node_at;             ///< -1: no node, 0 before numbering: marked
};

std::vector<std::array<int, 3>> filled_cells(const VoxelGrid& grid) {
  // The axis with the most cells runs slowest, as for the nodes.
  std::array<std::size_t, 3> axes = {0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](std::size_t a, std::size_t b) {
    return grid.count[a] < grid.count[b];
  });
  std::vector<std::array<int, 3>> cells;
  std::array<int, 3> cell{};
  for (cell[axes[2]] = 0; cell[axes[2]] < grid.count[axes[2]]; ++cell[axes[2]]) {
    for (cell[axes[1]] = 0; cell[axes[1]] < grid.count[axes[1]]; ++cell[axes[1]]) {
      for (cell[axes[0]] = 0; cell[axes[0]] < grid.count[axes[0]]; ++cell[axes[0]]) {
        if (grid.filled(cell[0], cell[1], cell[2])) cells.push_back(cell);
      }
    }
  }
  return cells;
}

/// Material names in the order of the rig, those that a cell has.
std::vector<std::string> used_materials(const Rig& rig, const VoxelGrid& grid) {
  std::vector<char> solid_used(rig.parts.size(), 0);
  for (const int solid : grid.solid_of_cell) {
    if (solid != VoxelGrid::kEmpty) solid_used[static_cast<std::size_t>(solid)] = 1;
  }
  std::vector<std::string> names;
  for (std::size_t s = 0; s < rig.parts.size(); ++s) {
    if (solid_used[s] == 0) continue;
    const std::string& name = rig.parts[s].material;
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  const auto rank = [&](const std::string& name) {
    return std::find_if(rig.materials.begin(),
                        rig.materials.end(),
                        [&](const RigMaterial& material) { return material.name == name; }) -
           rig.materials.begin();
  };
  std::stable_sort(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
    return rank(a) < rank(b);
  });
  return names;
}

}  // namespace

HexMesh mesh_part(const Rig& rig, double dx_m, ElementKind kind) {
  if (!(dx_m > 0.0) || !std::isfinite(dx_m)) {
    throw InputError(fmt::format("dx is {:.6g} mm, must be > 0", dx_m * kMillimetresPerMetre));
  }
  if (rig.parts.empty()) {
    throw InputError(fmt::format("{}: the rig has no part to mesh",
                                 rig.file.empty() ? rig.name : rig.file.string()));
  }
  const VoxelGrid grid = fill_voxels(rig, dx_m);
  check_grid(rig, grid, dx_m);

  HexMesh mesh;
  mesh.kind = kind;
  mesh.requested_dx_m = dx_m;
  mesh.actual_dx_m = grid.cell;
  mesh.material_names = used_materials(rig, grid);
  std::vector<int> material_of_solid;
  for (const PartSolid& solid : rig.parts) {
    const auto at =
        std::find(mesh.material_names.begin(), mesh.material_names.end(), solid.material);
    material_of_solid.push_back(static_cast<int>(at - mesh.material_names.begin()));
  }

  const std::vector<std::array<int, 3>> cells = filled_cells(grid);
  NodeNumbering numbering(grid, kind);
  const int nodes = nodes_per_element(kind);
  for (const auto& cell : cells) {
    for (int a = 0; a < nodes; ++a) numbering.node_at(numbering.lattice(cell, a)) = 0;
  }
  mesh.nodes = numbering.number_marked();
  mesh.elements.resize(nodes, static_cast<Eigen::Index>(cells.size()));
  for (std::size_t e = 0; e < cells.size(); ++e) {
    for (int a = 0; a < nodes; ++a) {
      mesh.elements(a, static_cast<Eigen::Index>(e)) =
          numbering.node_at(numbering.lattice(cells[e], a));
    }
    const int solid = grid.solid_of_cell[grid.index(cells[e][0], cells[e][1], cells[e][2])];
    mesh.material_of_element.push_back(material_of_solid[static_cast<std::size_t>(solid)]);
  }
  return mesh;
}

}  // namespace twang
