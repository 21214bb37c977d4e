// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

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
  [[nodiscard]] bool filled(int i, int j, int k) const;
};

/// Cells along one axis: max(1, round(length / dx)).
[[nodiscard]] double cells_along(double length_m, double dx_m);

/// Fills every cell whose centre lies in a solid; the last such solid counts.
/// @throws InputError if a solid is a surface file or there would be more than 50 million cells
[[nodiscard]] VoxelGrid fill_voxels(const Rig& rig, double dx_m);

/// What keeps a grid from being a mesh of the part.
struct VoxelFault {
  enum class Kind { None, Vanished, Covered, Disconnected };
  Kind kind = Kind::None;
  int solid = -1;  ///< that vanished, lies under later solids, or stands apart
};
[[nodiscard]] VoxelFault find_fault(const Rig& rig, const VoxelGrid& grid);

/// Smallest axis-aligned box around a solid [m].
[[nodiscard]] Box bounds_of(const PartSolid& solid);

}  // namespace twang
