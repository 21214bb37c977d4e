// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/part_solids.hpp"
#include "fem/detail/voxel_grid.hpp"

#include <cstddef>
#include <vector>

namespace twang {

/// How much of a cell belongs to a solid, what later solids override taken off.
struct CellShare {
  std::size_t cell = 0;  ///< of the grid
  int solid = 0;
  double share = 0.0;  ///< in (0, 1] [-]
};

/// The shares of all cells, by cell, then by solid.
///
/// Exact but for round-off where solids do not overlap or only boxes do (a cylinder as a prism of
/// its volume); where others overlap, the overlap is found at points spread over the cell, and of a
/// surface that crosses itself, where it does, the shares along lines spread over it.
[[nodiscard]] std::vector<CellShare> share_cells(const VoxelGrid& grid,
                                                 const std::vector<SolidGeometry>& solids);

}  // namespace twang
