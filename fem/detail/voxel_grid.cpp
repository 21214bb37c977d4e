// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/voxel_grid.hpp"

#include "core/error.hpp"
#include "core/units.hpp"
#include "fem/detail/surface_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace twang {
namespace {

constexpr double kMaxCells = 50e6;
/// A cell centre on a solid's face is counted as just above it, whatever round-off says [cells].
constexpr double kCentreNudge = 1e-6;
/// The same of a surface, whose file has single precision: above the rounding of its coordinates.
constexpr double kSurfaceNudge = 1e-4;
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

/// Places of the centres of cells [first, last) along an axis, moved a little beyond.
std::vector<double> centres(const VoxelGrid& grid, int axis, int first, int last, double nudge) {
  std::vector<double> places;
  for (int c = first; c < last; ++c) {
    places.push_back(grid.origin[axis] + (c + 0.5 + nudge) * grid.cell[axis]);
  }
  return places;
}

void fill_solid(VoxelGrid& grid, const SolidGeometry& geometry, int solid_index) {
  const Box& box = geometry.bounds;
  const auto [i0, i1] = cell_range(grid, 0, box.min.x(), box.max.x());
  const auto [j0, j1] = cell_range(grid, 1, box.min.y(), box.max.y());
  const auto [k0, k1] = cell_range(grid, 2, box.min.z(), box.max.z());
  const double nudge = geometry.surface ? kSurfaceNudge : kCentreNudge;
  const std::vector<double> x = centres(grid, 0, i0, i1, nudge);
  const std::vector<double> y = centres(grid, 1, j0, j1, nudge);
  const std::vector<double> z = centres(grid, 2, k0, k1, nudge);
  std::optional<SurfaceColumns> columns;
  if (geometry.surface) columns.emplace(geometry.surface->mesh, x, y);
  for (std::size_t k = 0; k < z.size(); ++k) {
    for (std::size_t j = 0; j < y.size(); ++j) {
      for (std::size_t i = 0; i < x.size(); ++i) {
        const bool inside = columns ? columns->winding(i, j, z[k]) > 0
                                    : contains(geometry.solid, Eigen::Vector3d(x[i], y[j], z[k]));
        if (!inside) continue;
        grid.solid_of_cell[grid.index(
            i0 + static_cast<int>(i), j0 + static_cast<int>(j), k0 + static_cast<int>(k))] =
            solid_index;
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

/// Whether the centre of any cell lies in `solid`, overridden or not.
bool has_centre(const VoxelGrid& grid, const SolidGeometry& solid) {
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

std::array<int, 3> VoxelGrid::place(std::size_t cell_index) const {
  const auto row = static_cast<std::size_t>(count[0]);
  const std::size_t layer = row * static_cast<std::size_t>(count[1]);
  return {static_cast<int>(cell_index % row),
          static_cast<int>(cell_index % layer / row),
          static_cast<int>(cell_index / layer)};
}

bool VoxelGrid::filled(int i, int j, int k) const {
  return solid_of_cell[index(i, j, k)] != kEmpty;
}

double cells_along(double length_m, double dx_m) {
  return std::max(1.0, std::floor(length_m / dx_m + 0.5 + kRoundingNudge));
}

VoxelGrid cut_into_cells(const Box& bounds, double dx_m) {
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
  return grid;
}

void fill_by_centres(VoxelGrid& grid, const std::vector<SolidGeometry>& solids) {
  for (std::size_t s = 0; s < solids.size(); ++s) fill_solid(grid, solids[s], static_cast<int>(s));
}

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

VoxelFault find_fault(const VoxelGrid& grid, const std::vector<SolidGeometry>& solids) {
  std::vector<std::size_t> own_cells(solids.size(), 0);
  for (const int solid : grid.solid_of_cell) {
    if (solid != VoxelGrid::kEmpty) ++own_cells[static_cast<std::size_t>(solid)];
  }
  VoxelFault covered;
  for (std::size_t s = 0; s < solids.size(); ++s) {
    if (own_cells[s] > 0) continue;
    const int solid = static_cast<int>(s);
    if (!has_centre(grid, solids[s])) return {VoxelFault::Kind::Vanished, solid};
    covered = {VoxelFault::Kind::Covered, solid};
  }
  const int island = find_island(grid);
  if (island >= 0) return {VoxelFault::Kind::Disconnected, island};
  return covered;
}

}  // namespace twang
