// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"
#include "rigs/rig.hpp"

#include <vector>

namespace twang {

/// The modes, ascending, that a rig's observable can see: those that move it by at least a
/// fiftieth of what the one does that moves it most, at equal energy. All, if the rig has none.
[[nodiscard]] std::vector<int> visible_modes(const Rig& rig, const MeshRung& rung);

}  // namespace twang
