// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"

#include <string>

namespace twang::app {

/// The meshes of a ladder, their frequencies at E = 1 Pa and the choice among them, as JSON.
[[nodiscard]] std::string ladder_json(const MeshLadder& ladder);

/// The same as tables to read.
[[nodiscard]] std::string ladder_text(const MeshLadder& ladder);

}  // namespace twang::app
