// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"

#include <Eigen/Core>

namespace twang {

/// How the nodes of a mesh move when the part grows: displacement per metre by which each of
/// its dimensions grows, (3 x num_nodes) [-].
///
/// Every outer face moves outwards along its normal by one half. On voxels nodes between two faces
/// move in proportion along the grid line through them, on other meshes as the mean of their
/// neighbours; mid-edge nodes stay midway.
[[nodiscard]] Eigen::Matrix3Xd outward_growth(const HexMesh& mesh);

}  // namespace twang
