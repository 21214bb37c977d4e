// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/cell_shares.hpp"

#include "fem/detail/enclosed_shares.hpp"
#include "fem/detail/surface_columns.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

namespace twang {
namespace {

/// Overlaps are found at so many points in all, more of them in a cell the fewer cells there are;
/// lines through a surface stay below kMaxLines.
constexpr double kMaxPoints = 2e6;
constexpr double kMaxLines = 2.5e5;
constexpr double kMaxPointsPerAxis = 64;
constexpr double kMaxLinesPerAxis = 512;

/// Cells of the grid that a box reaches into.
struct CellRange {
  std::array<int, 3> first;
  std::array<int, 3> last;  ///< one past
};

CellRange cells_in(const VoxelGrid& grid, const Box& box) {
  CellRange range{};
  for (std::size_t at = 0; at < 3; ++at) {
    const auto axis = static_cast<int>(at);
    const double low = (box.min[axis] - grid.origin[axis]) / grid.cell[axis];
    const double high = (box.max[axis] - grid.origin[axis]) / grid.cell[axis];
    const double cells = grid.count[at];
    range.first[at] = static_cast<int>(std::clamp(std::floor(low), 0.0, cells - 1.0));
    range.last[at] =
        std::max(range.first[at] + 1, static_cast<int>(std::clamp(std::ceil(high), 1.0, cells)));
  }
  return range;
}

template <typename Action>
void for_each_cell(const CellRange& range, Action&& action) {
  for (int k = range.first[2]; k < range.last[2]; ++k) {
    for (int j = range.first[1]; j < range.last[1]; ++j) {
      for (int i = range.first[0]; i < range.last[0]; ++i) action(i, j, k);
    }
  }
}

Box box_of_cell(const VoxelGrid& grid, int i, int j, int k) {
  const Eigen::Vector3d low = grid.origin + Eigen::Vector3d(i, j, k).cwiseProduct(grid.cell);
  return {low, low + grid.cell};
}

/// Overlap of [low, high] with [0, 1], both in cells.
double overlap_with_cell(double low, double high) {
  // Faces on the cells' own, but for round-off, cut nothing off.
  constexpr double kRounding = 1e-9;
  const double length = std::min(high, 1.0) - std::max(low, 0.0);
  return length > 1.0 - kRounding ? 1.0 : length < kRounding ? 0.0 : length;
}

void add_shares(const VoxelGrid& grid, const Box& box, int solid, std::vector<CellShare>& shares) {
  const CellRange range = cells_in(grid, box);
  std::array<std::vector<double>, 3> along;
  for (std::size_t at = 0; at < 3; ++at) {
    const auto axis = static_cast<int>(at);
    for (int c = range.first[at]; c < range.last[at]; ++c) {
      along[at].push_back(
          overlap_with_cell((box.min[axis] - grid.origin[axis]) / grid.cell[axis] - c,
                            (box.max[axis] - grid.origin[axis]) / grid.cell[axis] - c));
    }
  }
  for_each_cell(range, [&](int i, int j, int k) {
    const double share = along[0][static_cast<std::size_t>(i - range.first[0])] *
                         along[1][static_cast<std::size_t>(j - range.first[1])] *
                         along[2][static_cast<std::size_t>(k - range.first[2])];
    if (share > 0.0) shares.push_back({grid.index(i, j, k), solid, share});
  });
}

void add_shares(const VoxelGrid& grid,
                const SurfaceMesh& surface,
                int solid,
                std::vector<CellShare>& shares) {
  const CellRange range = cells_in(grid, bounds_of(surface));
  CellBlock block;
  block.cell = grid.cell;
  for (std::size_t at = 0; at < 3; ++at) {
    block.count[at] = range.last[at] - range.first[at];
    const auto axis = static_cast<int>(at);
    block.origin[axis] = grid.origin[axis] + range.first[at] * grid.cell[axis];
  }
  const std::vector<double> of_block = enclosed_shares(block, surface);
  std::size_t next = 0;
  for_each_cell(range, [&](int i, int j, int k) {
    const double share = of_block[next++];
    if (share > 0.0) shares.push_back({grid.index(i, j, k), solid, share});
  });
}

/// Lines through a cell along an axis across them, so that there are not too many in all.
int lines_per_cell(const VoxelGrid& grid, double most) {
  const double lines = static_cast<double>(grid.count[0]) * grid.count[1];
  return std::max(1, static_cast<int>(std::min(std::sqrt(kMaxLines / lines), most)));
}

/// Where `per_cell` lines or points stand in each cell along an axis.
std::vector<double> spread_over_cells(const VoxelGrid& grid, int axis, int per_cell) {
  std::vector<double> places;
  for (int p = 0; p < per_cell * grid.count[static_cast<std::size_t>(axis)]; ++p) {
    places.push_back(grid.origin[axis] + (p + 0.5) / per_cell * grid.cell[axis]);
  }
  return places;
}

/// Adds the part [low, high] of a line, in cells, to the cells along it.
void add_length(double low, double high, std::vector<double>& of_cell) {
  const double last = static_cast<double>(of_cell.size()) - 1.0;
  const auto first = static_cast<std::size_t>(std::clamp(std::floor(low), 0.0, last));
  for (std::size_t k = first; k < of_cell.size() && static_cast<double>(k) < high; ++k) {
    const auto at = static_cast<double>(k);
    of_cell[k] += std::max(0.0, std::min(high, at + 1.0) - std::max(low, at));
  }
}

/// What lines through a column of cells say of them.
struct ColumnShares {
  std::vector<double> inside;   ///< length in each cell around which the surface winds once or more
  std::vector<double> crossed;  ///< around which it winds otherwise than once or not at all
};

void add_line(const VoxelGrid& grid,
              std::span<const SurfaceColumns::Crossing> line,
              ColumnShares& shares) {
  int winding = 0;
  double entered = 0.0;
  for (const SurfaceColumns::Crossing& crossing : line) {
    const double z = (crossing.z - grid.origin.z()) / grid.cell.z();
    if (winding > 0) add_length(entered, z, shares.inside);
    if (winding > 1 || winding < 0) add_length(entered, z, shares.crossed);
    winding += crossing.turn;
    entered = z;
  }
}

/// Of a surface that crosses itself: shares along lines in the cells where it does.
void add_crossed_shares(const VoxelGrid& grid,
                        const SurfaceMesh& surface,
                        int solid,
                        std::vector<CellShare>& shares) {
  const std::vector<double> uncrossed =
      enclosed_shares({grid.origin, grid.cell, grid.count}, surface);
  const int per_cell = lines_per_cell(grid, kMaxLinesPerAxis);
  const SurfaceColumns columns(
      surface, spread_over_cells(grid, 0, per_cell), spread_over_cells(grid, 1, per_cell));
  const auto height = static_cast<std::size_t>(grid.count[2]);
  for (int j = 0; j < grid.count[1]; ++j) {
    for (int i = 0; i < grid.count[0]; ++i) {
      ColumnShares column = {std::vector<double>(height, 0.0), std::vector<double>(height, 0.0)};
      for (int line = 0; line < per_cell * per_cell; ++line) {
        add_line(grid,
                 columns.at(static_cast<std::size_t>(i * per_cell + line % per_cell),
                            static_cast<std::size_t>(j * per_cell + line / per_cell)),
                 column);
      }
      for (int k = 0; k < grid.count[2]; ++k) {
        const std::size_t cell = grid.index(i, j, k);
        const auto at = static_cast<std::size_t>(k);
        const double share = column.crossed[at] > 0.0
                                 ? overlap_with_cell(0.0, column.inside[at] / (per_cell * per_cell))
                                 : uncrossed[cell];
        if (share > 0.0) shares.push_back({cell, solid, share});
      }
    }
  }
}

/// Shares of a cell that only boxes reach into, from the pieces into which their faces cut it.
void resolve_boxes(const Box& cell,
                   const std::vector<SolidGeometry>& solids,
                   std::span<CellShare> shares) {
  std::array<std::vector<double>, 3> faces;
  for (std::size_t at = 0; at < 3; ++at) {
    const auto axis = static_cast<int>(at);
    faces[at] = {cell.min[axis], cell.max[axis]};
    for (const CellShare& share : shares) {
      const Box& box = solids[static_cast<std::size_t>(share.solid)].bounds;
      for (const double face : {box.min[axis], box.max[axis]}) {
        if (face > cell.min[axis] && face < cell.max[axis]) faces[at].push_back(face);
      }
    }
    std::sort(faces[at].begin(), faces[at].end());
  }
  for (CellShare& share : shares) share.share = 0.0;
  const double volume = (cell.max - cell.min).prod();
  for (std::size_t k = 0; k + 1 < faces[2].size(); ++k) {
    for (std::size_t j = 0; j + 1 < faces[1].size(); ++j) {
      for (std::size_t i = 0; i + 1 < faces[0].size(); ++i) {
        const Eigen::Vector3d low(faces[0][i], faces[1][j], faces[2][k]);
        const Eigen::Vector3d high(faces[0][i + 1], faces[1][j + 1], faces[2][k + 1]);
        const auto last = std::find_if(shares.rbegin(), shares.rend(), [&](const CellShare& share) {
          return contains(solids[static_cast<std::size_t>(share.solid)].solid, 0.5 * (low + high));
        });
        if (last != shares.rend()) last->share += (high - low).prod() / volume;
      }
    }
  }
  for (CellShare& share : shares) share.share = overlap_with_cell(0.0, share.share);
}

/// Takes off what later solids override, from points spread over the cell.
class OverlapSampler {
 public:
  OverlapSampler(const VoxelGrid& grid,
                 const std::vector<SolidGeometry>& solids,
                 std::size_t num_cells)
      : m_grid(grid), m_solids(solids), m_columns(solids.size()) {
    m_points = lines_per_cell(
        grid, std::min(kMaxPointsPerAxis, std::cbrt(kMaxPoints / static_cast<double>(num_cells))));
  }

  void resolve(int i, int j, int k, std::span<CellShare> shares) {
    std::vector<int> inside(shares.size(), 0);
    std::vector<int> overridden(shares.size(), 0);
    for (int point = 0; point < m_points * m_points * m_points; ++point) {
      const int pi = i * m_points + point % m_points;
      const int pj = j * m_points + point / m_points % m_points;
      const int pk = k * m_points + point / (m_points * m_points);
      bool taken = false;
      for (std::size_t s = shares.size(); s-- > 0;) {
        if (!is_inside(shares[s].solid, pi, pj, pk)) continue;
        ++inside[s];
        if (taken) ++overridden[s];
        taken = true;
      }
    }
    double covered = 0.0;
    for (std::size_t s = shares.size(); s-- > 0;) {
      const double whole = shares[s].share;
      const double lost = inside[s] > 0 ? whole * overridden[s] / inside[s] : 0.0;
      shares[s].share =
          std::clamp(whole - lost, std::max(0.0, whole - covered), std::min(whole, 1.0 - covered));
      covered += shares[s].share;
    }
  }

 private:
  [[nodiscard]] double place(int axis, int point) const {
    return m_grid.origin[axis] + (point + 0.5) / m_points * m_grid.cell[axis];
  }
  [[nodiscard]] bool is_inside(int solid, int i, int j, int k) {
    const auto at = static_cast<std::size_t>(solid);
    const SolidGeometry& geometry = m_solids[at];
    if (!geometry.surface) {
      return contains(geometry.solid, Eigen::Vector3d(place(0, i), place(1, j), place(2, k)));
    }
    if (!m_columns[at]) {
      m_columns[at].emplace(geometry.surface->mesh,
                            spread_over_cells(m_grid, 0, m_points),
                            spread_over_cells(m_grid, 1, m_points));
    }
    return m_columns[at]->winding(
               static_cast<std::size_t>(i), static_cast<std::size_t>(j), place(2, k)) > 0;
  }

  const VoxelGrid& m_grid;
  const std::vector<SolidGeometry>& m_solids;
  std::vector<std::optional<SurfaceColumns>> m_columns;  ///< made when first asked
  int m_points = 1;
};

/// Shares of cells that several solids reach into, where the last does not override all.
class Resolver {
 public:
  Resolver(const VoxelGrid& grid, const std::vector<SolidGeometry>& solids)
      : m_grid(grid), m_solids(solids) {}

  /// Resolves a cell, or puts it off until it is known how many must be sampled.
  void add(std::span<CellShare> shares) {
    if (shares.back().share == 1.0) {  // the last one overrides all
      for (CellShare& share : shares.first(shares.size() - 1)) share.share = 0.0;
    } else if (std::all_of(shares.begin(), shares.end(), [&](const CellShare& share) {
                 const auto solid = static_cast<std::size_t>(share.solid);
                 return std::holds_alternative<Box>(m_solids[solid].solid.shape);
               })) {
      const auto [i, j, k] = m_grid.place(shares.front().cell);
      resolve_boxes(box_of_cell(m_grid, i, j, k), m_solids, shares);
    } else {
      m_to_sample.push_back(shares);
    }
  }

  void finish() {
    if (m_to_sample.empty()) return;
    OverlapSampler sampler(m_grid, m_solids, m_to_sample.size());
    for (const std::span<CellShare> shares : m_to_sample) {
      const auto [i, j, k] = m_grid.place(shares.front().cell);
      sampler.resolve(i, j, k, shares);
    }
  }

 private:
  const VoxelGrid& m_grid;
  const std::vector<SolidGeometry>& m_solids;
  std::vector<std::span<CellShare>> m_to_sample;
};

}  // namespace

std::vector<CellShare> share_cells(const VoxelGrid& grid,
                                   const std::vector<SolidGeometry>& solids) {
  std::vector<CellShare> shares;
  for (std::size_t s = 0; s < solids.size(); ++s) {
    const int solid = static_cast<int>(s);
    if (const auto* box = std::get_if<Box>(&solids[s].solid.shape)) {
      add_shares(grid, *box, solid, shares);
    } else if (const auto* cylinder = std::get_if<Cylinder>(&solids[s].solid.shape)) {
      add_shares(grid, surface_of(*cylinder), solid, shares);
    } else if (solids[s].crosses_itself) {
      add_crossed_shares(grid, solids[s].surface->mesh, solid, shares);
    } else {
      add_shares(grid, solids[s].surface->mesh, solid, shares);
    }
  }
  const auto by_cell = [](const CellShare& a, const CellShare& b) { return a.cell < b.cell; };
  if (!std::is_sorted(shares.begin(), shares.end(), by_cell)) {
    std::stable_sort(shares.begin(), shares.end(), by_cell);
  }
  if (solids.size() < 2) return shares;
  Resolver resolver(grid, solids);
  for (std::size_t begin = 0; begin < shares.size();) {
    std::size_t end = begin + 1;
    while (end < shares.size() && shares[end].cell == shares[begin].cell) ++end;
    if (end - begin > 1) resolver.add(std::span(shares).subspan(begin, end - begin));
    begin = end;
  }
  resolver.finish();
  std::erase_if(shares, [](const CellShare& share) { return !(share.share > 0.0); });
  return shares;
}

}  // namespace twang
