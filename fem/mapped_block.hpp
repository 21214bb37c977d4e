// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"

#include <array>
#include <functional>

namespace twang {

/// The unit cube cut into cells, as a curved block.
struct MappedBlock {
  std::array<int, 3> cells = {1, 1, 1};  ///< along s, each >= 1
  /// Where the point s of [0, 1]³ stands [m]; keeps the orientation of space.
  std::function<Eigen::Vector3d(const Eigen::Vector3d& s)> map;
  std::array<bool, 3> closed = {false, false, false};  ///< s = 1 is s = 0 again, as around a ring
};

/// A structured mesh of one material "part": nodes, those in the middle of edges too, stand where
/// the map puts them.
/// @throws InputError if a number of cells is < 1 (< 3 along a closed axis), there is no map, or an
/// element is flat or turned inside out
[[nodiscard]] HexMesh mesh_block(const MappedBlock& block, ElementKind kind);

}  // namespace twang
