// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang {

/// Infinitesimal rigid motions of the mesh, displaced by `u`, that leave the held nodes at rest,
/// (3 num_nodes x 0..6): six without held nodes, three about one, one about two or more in a line.
[[nodiscard]] Eigen::MatrixXd rigid_motions(const HexMesh& mesh,
                                            const std::vector<int>& held_nodes,
                                            const Eigen::VectorXd& u);

}  // namespace twang
