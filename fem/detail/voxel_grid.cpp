// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/voxel_grid.hpp"

#include "core/error.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

constexpr double kMaxCells = 50e6;
/// A cell centre on a solid's face is counted as just above it, whatever round-off says [cells].
constexpr double kCentreNudge = 1e-6;
/// Keeps round(length / dx) from falling to the side of round-off at exact halves [cells].
constexpr double kRoundingNudge = 1e-9;

/// First and one past the last cell along `axis` whose centre may lie between `low` and `high`.
std::array<int, 2> cell_range(const VoxelGrid& grid, int axis, double low, double high) {
  const auto at = static_cast<std::size_t>(axis);
  const double first = std::floor((low - grid.origin[axis]) / grid.cell[axis] - 0.5);
  const double last = std::ceil((high - grid.origin[axis]) / grid.cell[axis] + 0.5);
  return {static_cast<int>(std::clamp(first, 0.0, static_cast<double>(grid.count[at]))),
          static_cast<int>(std::clamp(last, 0.0, static_cast<double>(grid.count[at])))};
}

void check_solid(const PartSolid& solid) {
  const auto* surface = std::get_if<SurfaceFile>(&solid.shape);
  if (surface == nullptr) return;
  throw InputError(
      fmt::format("{}: is a surface, which cannot be meshed yet; a part must be made of boxes and "
                  "cylinders",
                  surface->file.string()));
}

void fill_solid(VoxelGrid& grid, const PartSolid& solid, int solid_index) {
  const Box box = bounds_of(solid);
  const auto [i0, i1] = cell_range(grid, 0, box.min.x(), box.max.x());
  const auto [j0, j1] = cell_range(grid, 1, box.min.y(), box.max.y());
  const auto [k0, k1] = cell_range(grid, 2, box.min.z(), box.max.z());
  for (int k = k0; k < k1; ++k) {
    for (int j = j0; j < j1; ++j) {
      for (int i = i0; i < i1; ++i) {
        const Eigen::Vector3d offset = Eigen::Vector3d(i, j, k).array() + 0.5 + kCentreNudge;
        const Eigen::Vector3d centre = grid.origin + offset.cwiseProduct(grid.cell);
        if (contains(solid, centre)) grid.solid_of_cell[grid.index(i, j, k)] = solid_index;
      }
    }
  }
}

/// Marks every filled cell that faces lead to from `start`.
void flood(const VoxelGrid& grid, std::array<int, 3> start, std::vector<char>& reached) {
  std::vector<std::array<int, 3>> front = {start};
  reached[grid.index(start[0], start[1], start[2])] = 1;
  while (!front.empty()) {
    const std::array<int, 3> cell = front.back();
    front.pop_back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        std::array<int, 3> next = cell;
        next[axis] += step;
        if (next[axis] < 0 || next[axis] >= grid.count[axis]) continue;
        if (!grid.filled(next[0], next[1], next[2])) continue;
        char& mark = reached[grid.index(next[0], next[1], next[2])];
        if (mark == 0) front.push_back(next);
        mark = 1;
      }
    }
  }
}

/// A solid of a cell that faces do not connect with the first filled cell; -1 if there is none.
int find_island(const VoxelGrid& grid) {
  std::vector<char> reached(grid.num_cells(), 0);
  bool started = false;
  for (int k = 0; k < grid.count[2]; ++k) {
    for (int j = 0; j < grid.count[1]; ++j) {
      for (int i = 0; i < grid.count[0]; ++i) {
        const std::size_t cell = grid.index(i, j, k);
        if (!grid.filled(i, j, k) || reached[cell] != 0) continue;
        if (started) return grid.solid_of_cell[cell];
        flood(grid, {i, j, k}, reached);
        started = true;
      }
    }
  }
  return -1;
}

/// Whether the centre of any cell lies in `solid`, overridden or not.
bool has_centre(const VoxelGrid& grid, const PartSolid& solid) {
  VoxelGrid alone = grid;
  std::fill(alone.solid_of_cell.begin(), alone.solid_of_cell.end(), VoxelGrid::kEmpty);
  fill_solid(alone, solid, 0);
  return std::find(alone.solid_of_cell.begin(), alone.solid_of_cell.end(), 0) !=
         alone.solid_of_cell.end();
}

}  // namespace

std::size_t VoxelGrid::num_cells() const {
  return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) *
         static_cast<std::size_t>(count[2]);
}

std::size_t VoxelGrid::index(int i, int j, int k) const {
  return static_cast<std::size_t>(i) +
         static_cast<std::size_t>(count[0]) *
             (static_cast<std::size_t>(j) +
              static_cast<std::size_t>(count[1]) * static_cast<std::size_t>(k));
}

bool VoxelGrid::filled(int i, int j, int k) const {
  return solid_of_cell[index(i, j, k)] != kEmpty;
}

double cells_along(double length_m, double dx_m) {
  return std::max(1.0, std::floor(length_m / dx_m + 0.5 + kRoundingNudge));
}

Box bounds_of(const PartSolid& solid) {
  Rig alone;
  alone.parts.push_back(solid);
  return alone.bounding_box();
}

VoxelGrid fill_voxels(const Rig& rig, double dx_m) {
  for (const PartSolid& solid : rig.parts) check_solid(solid);
  const Box bounds = rig.bounding_box();
  VoxelGrid grid;
  grid.origin = bounds.min;
  double num_cells = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double length = bounds.max[axis] - bounds.min[axis];
    const double cells = cells_along(length, dx_m);
    num_cells *= cells;
    if (num_cells > kMaxCells) {
      throw InputError(
          fmt::format("dx is {:.6g} mm, which cuts the part into more than {:.0f} "
                      "million cells, must be larger",
                      dx_m * kMillimetresPerMetre,
                      kMaxCells * 1e-6));
    }
    grid.count[static_cast<std::size_t>(axis)] = static_cast<int>(cells);
    grid.cell[axis] = length / cells;
  }
  grid.solid_of_cell.assign(grid.num_cells(), VoxelGrid::kEmpty);
  for (std::size_t s = 0; s < rig.parts.size(); ++s) {
    fill_solid(grid, rig.parts[s], static_cast<int>(s));
  }
  return grid;
}

VoxelFault find_fault(const Rig& rig, const VoxelGrid& grid) {
  std::vector<std::size_t> own_cells(rig.parts.size(), 0);
  for (const int solid : grid.solid_of_cell) {
    if (solid != VoxelGrid::kEmpty) ++own_cells[static_cast<std::size_t>(solid)];
  }
  VoxelFault covered;
  for (std::size_t s = 0; s < rig.parts.size(); ++s) {
    if (own_cells[s] > 0) continue;
    const int solid = static_cast<int>(s);
    if (!has_centre(grid, rig.parts[s])) return {VoxelFault::Kind::Vanished, solid};
    covered = {VoxelFault::Kind::Covered, solid};
  }
  const int island = find_island(grid);
  if (island >= 0) return {VoxelFault::Kind::Disconnected, island};
  return covered;
}

}  // namespace twang
