// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/partial_cells.hpp"

#include "core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace twang {
namespace {

/// Cells emptier than this are given to a neighbour: they would cost unknowns and condition [-].
constexpr double kLeastFill = 0.05;
/// What counts as left out, and as alone [-].
constexpr double kSubstantial = 0.25;
constexpr double kFeature = 0.1;
/// Volumes that differ by more are said [-].
constexpr double kNotableDifference = 0.01;
/// A material with less of a cell than this is a trace of round-off or sampling [-].
constexpr double kTrace = 0.01;

double density_of(const Rig& rig, int solid) {
  const RigMaterial* material =
      rig.find_material(rig.parts[static_cast<std::size_t>(solid)].material);
  return material != nullptr ? material->density_kg_m3 : 1.0;
}

/// Calls `action` with the shares of each cell.
template <typename Action>
void for_each_cell(const std::vector<CellShare>& shares, Action&& action) {
  for (std::size_t begin = 0; begin < shares.size();) {
    std::size_t end = begin + 1;
    while (end < shares.size() && shares[end].cell == shares[begin].cell) ++end;
    action(std::span(shares).subspan(begin, end - begin));
    begin = end;
  }
}

double sum_of(std::span<const CellShare> shares) {
  double sum = 0.0;
  for (const CellShare& share : shares) sum += share.share;
  return sum;
}

/// What of a cell is of the same material as the solid `like`.
double share_of_material(const Rig& rig, std::span<const CellShare> shares, int like) {
  const std::string& name = rig.parts[static_cast<std::size_t>(like)].material;
  double sum = 0.0;
  for (const CellShare& share : shares) {
    if (rig.parts[static_cast<std::size_t>(share.solid)].material == name) sum += share.share;
  }
  return sum;
}

/// The last solid of the material that has most of a cell.
int main_solid(const Rig& rig, std::span<const CellShare> shares) {
  int best = shares.front().solid;
  double most = 0.0;
  for (const CellShare& share : shares) {
    const double its = share_of_material(rig, shares, share.solid);
    if (its < most) continue;
    most = its;
    best = share.solid;
  }
  return best;
}

/// Calls `action` with the index of each of up to 26 cells around one.
template <typename Action>
void for_each_neighbour(const VoxelGrid& grid, std::size_t cell, Action&& action) {
  const std::array<int, 3> place = grid.place(cell);
  const auto low = [](int c) { return std::max(c - 1, 0); };
  const auto high = [&](std::size_t axis) {
    return std::min(place[axis] + 1, grid.count[axis] - 1);
  };
  for (int k = low(place[2]); k <= high(2); ++k) {
    for (int j = low(place[1]); j <= high(1); ++j) {
      for (int i = low(place[0]); i <= high(0); ++i) {
        if (grid.index(i, j, k) != cell) action(grid.index(i, j, k));
      }
    }
  }
}

}  // namespace

CellFill fill_by_shares(VoxelGrid& grid, const Rig& rig, const std::vector<CellShare>& shares) {
  double fullest = 0.0;
  for_each_cell(shares, [&](auto cell) { fullest = std::max(fullest, sum_of(cell)); });
  const double least = std::min(kLeastFill, 0.5 * fullest);
  CellFill fill;
  fill.volume.assign(grid.num_cells(), 0.0);
  fill.mass.assign(grid.num_cells(), 0.0);
  const auto add = [&](std::size_t to, std::span<const CellShare> what) {
    const double density = density_of(rig, grid.solid_of_cell[to]);
    for (const CellShare& share : what) {
      fill.volume[to] += share.share;
      fill.mass[to] += share.share * density_of(rig, share.solid) / density;
    }
  };
  for_each_cell(shares, [&](auto cell) {
    if (sum_of(cell) < least) return;
    grid.solid_of_cell[cell.front().cell] = main_solid(rig, cell);
    add(cell.front().cell, cell);
  });
  const std::vector<double> own = fill.volume;
  for_each_cell(shares, [&](auto cell) {
    if (sum_of(cell) >= least) return;
    std::size_t to = cell.front().cell;
    double best = 0.0;
    for_each_neighbour(grid, cell.front().cell, [&](std::size_t other) {
      if (own[other] <= best) return;
      best = own[other];
      to = other;
    });
    if (best > 0.0) add(to, cell);
  });
  return fill;
}

GridLosses find_losses(const VoxelGrid& grid,
                       const std::vector<CellShare>& shares,
                       const std::vector<double>& fill) {
  GridLosses losses;
  for_each_cell(shares, [&](auto cell) {
    const double share = sum_of(cell);
    losses.part_volume_m3 += share;
    if (share < kFeature || grid.solid_of_cell[cell.front().cell] != VoxelGrid::kEmpty) return;
    if (share >= kSubstantial) ++losses.left_out;
    bool alone = true;
    for_each_neighbour(grid, cell.front().cell, [&](std::size_t other) {
      alone = alone && grid.solid_of_cell[other] == VoxelGrid::kEmpty;
    });
    if (alone) ++losses.alone;
  });
  for (std::size_t c = 0; c < grid.num_cells(); ++c) {
    if (grid.solid_of_cell[c] == VoxelGrid::kEmpty) continue;
    losses.grid_volume_m3 += fill.empty() ? 1.0 : fill[c];
  }
  losses.part_volume_m3 *= grid.cell_volume();
  losses.grid_volume_m3 *= grid.cell_volume();
  return losses;
}

std::string GridLosses::message(double dx_m) const {
  const double difference = grid_volume_m3 / part_volume_m3 - 1.0;
  if (std::abs(difference) <= kNotableDifference && alone == 0) return {};
  constexpr double kCubicMillimetres = 1e9;
  std::string text = fmt::format(
      "at dx = {:.4g} mm the mesh has {:.2g} % {} volume than the part ({:.5g} instead of "
      "{:.5g} mm³)",
      dx_m * kMillimetresPerMetre,
      100.0 * std::abs(difference),
      difference < 0.0 ? "less" : "more",
      grid_volume_m3 * kCubicMillimetres,
      part_volume_m3 * kCubicMillimetres);
  if (left_out > 0) {
    text += fmt::format(
        "; {} cells are a quarter full or more and left out, their centres lie outside", left_out);
  }
  if (alone > 0) {
    text += fmt::format(
        "; {} cells that the part reaches touch no cell of the mesh: thin features "
        "are lost there",
        alone);
  }
  return text;
}

long count_mixed(const Rig& rig, const std::vector<CellShare>& shares) {
  long count = 0;
  for_each_cell(shares, [&](auto cell) {
    const double sum = sum_of(cell);
    for (const CellShare& share : cell) {
      const double its = share_of_material(rig, cell, share.solid);
      if (its <= kTrace || sum - its <= kTrace) continue;
      ++count;
      return;
    }
  });
  return count;
}

}  // namespace twang
