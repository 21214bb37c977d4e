// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"
#include "rigs/rig.hpp"

namespace twang {

/// The rig with solids in place of its mesh file: for each material the outside of its elements,
/// as flat triangles between their corners.
/// @param mesh  that of the file
[[nodiscard]] Rig with_surfaces_of(const Rig& rig, const HexMesh& mesh);

}  // namespace twang
