// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "core/units.hpp"
#include "fem/detail/partial_cells.hpp"
#include "fem/detail/voxel_grid.hpp"
#include "fem/hex_mesh.hpp"
#include "fem/read_mesh.hpp"

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

double trial_cells(const Box& bounds, double dx_m) {
  double cells = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    cells *= cells_along(bounds.max[axis] - bounds.min[axis], dx_m);
  }
  return cells;
}

/// The first of thickness, thickness / 2, ... of the solid at fault (or of dx / 2, dx / 4, ... if
/// it is thicker than that) at which nothing is wrong with the grid.
std::optional<double> find_dx_that_works(const std::vector<SolidGeometry>& solids,
                                         double dx_m,
                                         const VoxelFault& fault) {
  const Box bounds = bounds_of(solids);
  const Box own = solids[static_cast<std::size_t>(fault.solid)].bounds;
  const double thickness = (own.max - own.min).minCoeff();
  double trial = thickness > 0.0 ? std::min(thickness, 0.5 * dx_m) : 0.5 * dx_m;
  for (int k = 0; k < kMaxTrials && trial_cells(bounds, trial) <= kMaxTrialCells; ++k) {
    VoxelGrid grid = cut_into_cells(bounds, trial);
    fill_by_centres(grid, solids);
    if (find_fault(grid, solids).kind == Kind::None) return trial;
    trial *= 0.5;
  }
  return std::nullopt;
}

/// @throws InputError unless the grid is whole, or lacks no more than a solid under later ones
void check_grid(const Rig& rig,
                const std::vector<SolidGeometry>& solids,
                const VoxelGrid& grid,
                double dx_m) {
  const VoxelFault fault = find_fault(grid, solids);
  if (fault.kind == Kind::None) return;
  const std::optional<double> works = find_dx_that_works(solids, dx_m, fault);
  if (fault.kind == Kind::Covered && !works) return;
  const std::string reason =
      fault.kind == Kind::Disconnected ? "is not connected by faces with the rest of the part"
      : fault.kind == Kind::Covered    ? "vanishes under later ones, no cell of it is left"
                                       : "vanishes, no cell has its centre in it";
  const std::string advice =
      works ? fmt::format("dx must be smaller, {:.6g} mm would do", *works * kMillimetresPerMetre)
      : fault.kind == Kind::Disconnected
          ? std::string("bodies that do not touch must be joined, and dx smaller than what joins")
          : std::string("dx must be much smaller, or the part mended");
  throw InputError(fmt::format("{} {} at dx = {:.6g} mm; {}",
                               describe_solid(rig, fault.solid),
                               reason,
                               dx_m * kMillimetresPerMetre,
                               advice));
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

/// @throws InputError if a material has no cell or the cells do not hang together
void check_partial_grid(const Rig& rig, const VoxelGrid& grid, double dx_m) {
  const std::vector<std::string> used = used_materials(rig, grid);
  for (std::size_t s = 0; s < rig.parts.size(); ++s) {
    if (std::find(used.begin(), used.end(), rig.parts[s].material) != used.end()) continue;
    throw InputError(
        fmt::format("{} vanishes, no cell is mostly of its material at dx = {:.6g} mm; dx must be "
                    "smaller",
                    describe_solid(rig, static_cast<int>(s)),
                    dx_m * kMillimetresPerMetre));
  }
  const int island = find_island(grid);
  if (island < 0) return;
  throw InputError(
      fmt::format("{} is not connected by faces with the rest of the part at dx = "
                  "{:.6g} mm; dx must be smaller, or the part mended",
                  describe_solid(rig, island),
                  dx_m * kMillimetresPerMetre));
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

/// Whether every solid is a box whose faces are faces of cells: then cells are full or empty.
bool fits_cells(const VoxelGrid& grid, const std::vector<SolidGeometry>& solids) {
  constexpr double kRounding = 1e-6;  // of a cell
  return std::all_of(solids.begin(), solids.end(), [&](const SolidGeometry& geometry) {
    if (!std::holds_alternative<Box>(geometry.solid.shape)) return false;
    for (const Eigen::Vector3d& corner : {geometry.bounds.min, geometry.bounds.max}) {
      const Eigen::Array3d place = (corner - grid.origin).cwiseQuotient(grid.cell);
      if (((place - place.round()).abs() > kRounding).any()) return false;
    }
    return true;
  });
}

/// A grid with how full its cells are (empty: full), what it lost and what is to be said of it.
struct FilledGrid {
  VoxelGrid grid;
  CellFill fill;
  double part_volume_m3 = 0.0;
  std::vector<std::string> notes;
};

FilledGrid fill_grid(const Rig& rig, const std::vector<SolidGeometry>& solids, double dx_m) {
  FilledGrid result;
  VoxelGrid& grid = result.grid;
  grid = cut_into_cells(bounds_of(solids), dx_m);
  const bool partial = rig.meshing.partial_cells != PartialCells::None;
  if (!partial) {
    fill_by_centres(grid, solids);
    check_grid(rig, solids, grid, dx_m);
  }
  for (const SolidGeometry& solid : solids) {
    if (!solid.surface) continue;
    for (const std::string& note : solid.surface->notes) result.notes.push_back(note);
  }
  if (!partial && fits_cells(grid, solids)) {
    const auto full = std::count_if(grid.solid_of_cell.begin(),
                                    grid.solid_of_cell.end(),
                                    [](int solid) { return solid != VoxelGrid::kEmpty; });
    result.part_volume_m3 = static_cast<double>(full) * grid.cell_volume();
    return result;
  }
  const std::vector<CellShare> shares = share_cells(grid, solids);
  if (partial) {
    result.fill = fill_by_shares(grid, rig, shares);
    check_partial_grid(rig, grid, dx_m);
  }
  const GridLosses losses = find_losses(grid, shares, result.fill.volume);
  result.part_volume_m3 = losses.part_volume_m3;
  if (std::string note = losses.message(dx_m); !note.empty()) {
    result.notes.push_back(std::move(note));
  }
  return result;
}

void check_dx(const Rig& rig, double dx_m) {
  if (!(dx_m > 0.0) || !std::isfinite(dx_m)) {
    throw InputError(fmt::format("dx is {:.6g} mm, must be > 0", dx_m * kMillimetresPerMetre));
  }
  if (rig.parts.empty()) {
    throw InputError(fmt::format("{}: the rig has no part to mesh",
                                 rig.file.empty() ? rig.name : rig.file.string()));
  }
}

/// How full the elements are, in the order of the elements.
void set_fill(HexMesh& mesh,
              const FilledGrid& filled,
              const std::vector<std::array<int, 3>>& cells,
              bool with_stiffness) {
  const auto count = static_cast<Eigen::Index>(cells.size());
  mesh.fill.resize(count);
  mesh.mass_fill.resize(count);
  for (Eigen::Index e = 0; e < count; ++e) {
    const auto& cell = cells[static_cast<std::size_t>(e)];
    const std::size_t at = filled.grid.index(cell[0], cell[1], cell[2]);
    mesh.fill[e] = filled.fill.volume[at];
    mesh.mass_fill[e] = filled.fill.mass[at];
  }
  if (with_stiffness) mesh.stiffness_fill = mesh.fill;
}

}  // namespace

HexMesh mesh_part(const Rig& rig, double dx_m, ElementKind kind) {
  if (rig.meshing.file) return read_mesh_of(rig, kind);
  check_dx(rig, dx_m);
  FilledGrid filled = fill_grid(rig, read_solids(rig), dx_m);
  const VoxelGrid& grid = filled.grid;

  HexMesh mesh;
  mesh.kind = kind;
  mesh.requested_dx_m = dx_m;
  mesh.actual_dx_m = grid.cell;
  mesh.part_volume_m3 = filled.part_volume_m3;
  mesh.notes = std::move(filled.notes);
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
  if (!filled.fill.volume.empty()) {
    set_fill(mesh, filled, cells, rig.meshing.partial_cells == PartialCells::MassAndStiffness);
  }
  return mesh;
}

MaterialMixing count_mixed_cells(const Rig& rig, double dx_m) {
  check_dx(rig, dx_m);
  const std::vector<SolidGeometry> solids = read_solids(rig);
  const VoxelGrid grid = cut_into_cells(bounds_of(solids), dx_m);
  const std::vector<CellShare> shares = share_cells(grid, solids);
  MaterialMixing mixing;
  mixing.actual_dx_m = grid.cell;
  mixing.num_mixed = count_mixed(rig, shares);
  std::size_t last = grid.num_cells();
  for (const CellShare& share : shares) {
    if (share.cell != last) ++mixing.num_cells;
    last = share.cell;
  }
  return mixing;
}

}  // namespace twang
