// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/part_solids.hpp"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace twang {

/// The bounding box of a part cut into equal cells, each with the solid that fills it.
struct VoxelGrid {
  static constexpr int kEmpty = -1;

  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< lower corner [m]
  Eigen::Vector3d cell = Eigen::Vector3d::Zero();    ///< size of a cell [m]
  std::array<int, 3> count = {0, 0, 0};              ///< cells along x, y, z
  std::vector<int> solid_of_cell;                    ///< index into rig.parts or kEmpty; x fastest

  [[nodiscard]] std::size_t num_cells() const;
  [[nodiscard]] std::size_t index(int i, int j, int k) const;
  [[nodiscard]] std::array<int, 3> place(std::size_t cell) const;  ///< i, j, k
  [[nodiscard]] bool filled(int i, int j, int k) const;
  [[nodiscard]] double cell_volume() const { return cell.prod(); }
};

/// Cells along one axis: max(1, round(length / dx)).
[[nodiscard]] double cells_along(double length_m, double dx_m);

/// Cuts a box into cells, all empty.
/// @throws InputError if there would be more than 50 million cells
[[nodiscard]] VoxelGrid cut_into_cells(const Box& bounds, double dx_m);

/// Fills every cell whose centre lies in a solid; the last such solid counts.
void fill_by_centres(VoxelGrid& grid, const std::vector<SolidGeometry>& solids);

/// What keeps a grid from being a mesh of the part.
struct VoxelFault {
  enum class Kind { None, Vanished, Covered, Disconnected };
  Kind kind = Kind::None;
  int solid = -1;  ///< that vanished, lies under later solids, or stands apart
};
/// Of a grid filled by centres.
[[nodiscard]] VoxelFault find_fault(const VoxelGrid& grid,
                                    const std::vector<SolidGeometry>& solids);
/// A solid of a cell that faces do not connect with the first filled cell; -1 if there is none.
[[nodiscard]] int find_island(const VoxelGrid& grid);

}  // namespace twang
