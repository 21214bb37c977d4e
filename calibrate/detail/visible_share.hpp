// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace twang::detail {

/// How much each mode moves the columns of a trace at equal energy, over the most that one does,
/// 0 to 1. A column is the rig's observable, a moving marker's coordinate, or unknown; with an
/// unknown one a mode counts with the node that it moves most.
[[nodiscard]] Eigen::VectorXd visible_shares(const Rig& rig,
                                             const MeshRung& rung,
                                             const std::vector<std::string>& columns);

}  // namespace twang::detail
