// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"

namespace twang {

/// Cuts each element into eight at the middles of its edges, faces and itself, by its own shape
/// functions; what was shared stays shared. Mid-edge nodes of hex20 are then put midway. Materials
/// and fills are inherited, groups and notes kept.
[[nodiscard]] HexMesh refine_uniformly(const HexMesh& mesh);

}  // namespace twang
