// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/cell_shares.hpp"

#include <string>
#include <vector>

namespace twang {

/// How full the cells of a grid are, by cell [-].
struct CellFill {
  std::vector<double> volume;  ///< of the part in it, over the cell's
  std::vector<double> mass;    ///< of what is in it, over that of a cell full of its material
};

/// Fills every cell of which a least share belongs to the part, with the material that has most of
/// it; what lies in emptier cells is added to their fullest neighbour, so that no mass is lost.
///
/// A cell may thereby be a little more than full.
[[nodiscard]] CellFill fill_by_shares(VoxelGrid& grid,
                                      const Rig& rig,
                                      const std::vector<CellShare>& shares);

/// What a grid leaves out of a part and adds to it.
struct GridLosses {
  double part_volume_m3 = 0.0;
  double grid_volume_m3 = 0.0;
  long left_out = 0;  ///< empty cells that are a quarter full or more
  long alone = 0;     ///< empty cells, a tenth full or more, without a filled neighbour

  /// One sentence for a person; empty if the volumes agree to a hundredth and nothing stands alone.
  [[nodiscard]] std::string message(double dx_m) const;
};
/// @param fill  how full filled cells are taken; empty: full
[[nodiscard]] GridLosses find_losses(const VoxelGrid& grid,
                                     const std::vector<CellShare>& shares,
                                     const std::vector<double>& fill);

/// Cells that hold more than a hundredth of each of two materials.
[[nodiscard]] long count_mixed(const Rig& rig, const std::vector<CellShare>& shares);

}  // namespace twang
