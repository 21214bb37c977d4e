// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/surface_mesh.hpp"

#include <array>
#include <vector>

namespace twang {

/// A box of equal cells, x fastest.
struct CellBlock {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< lower corner [m]
  Eigen::Vector3d cell = Eigen::Vector3d::Zero();    ///< size of a cell [m]
  std::array<int, 3> count = {0, 0, 0};
};

/// What share of each cell a closed surface that faces outwards encloses, in [0, 1].
///
/// Exact but for round-off where the surface winds around a point at most once: each triangle is
/// cut at the cells' faces, and what lies below a piece is added, with its sign, to the cells below
/// (the divergence theorem in each column of cells). O(triangles + pieces + cells). Parts of the
/// surface beside the block are taken as if they lay in its outermost cells.
[[nodiscard]] std::vector<double> enclosed_shares(const CellBlock& block,
                                                  const SurfaceMesh& surface);

/// A prism of the volume of `cylinder` that stands for it.
[[nodiscard]] SurfaceMesh surface_of(const Cylinder& cylinder);

}  // namespace twang
