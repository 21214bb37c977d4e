// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"

#include <Eigen/Core>

namespace twang {

/// Nodal vector fields of a voxel mesh at many points, as `locate` would find each: inside by shape
/// functions, beside the mesh by its nearest element.
///
/// @param fields  one a column, (3 num_nodes x k)
/// @param points  (3 x n) [m]
/// @return        (3 n x k)
/// Cost: a few neighbouring cells a point, not the whole mesh.
[[nodiscard]] Eigen::MatrixXd sample_fields(const HexMesh& mesh,
                                            const Eigen::MatrixXd& fields,
                                            const Eigen::Matrix3Xd& points);

}  // namespace twang
