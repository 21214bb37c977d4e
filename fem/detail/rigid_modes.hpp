// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"

#include <Eigen/Core>

namespace twang {

/// Infinitesimal rigid motions of the mesh, displaced by `u`, that leave all that is held at rest,
/// (3 num_nodes x 0..6): six of a free body, three about one held node, one about two or more in a
/// line.
[[nodiscard]] Eigen::MatrixXd rigid_motions(const HexMesh& mesh,
                                            const FreeDofs& free,
                                            const Eigen::VectorXd& u);

}  // namespace twang
