// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/closed_surface.hpp"
#include "rigs/rig.hpp"

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// A solid of a part, its surface read.
struct SolidGeometry {
  PartSolid solid;
  Box bounds;                            ///< [m]
  std::optional<ClosedSurface> surface;  ///< of a surface file
  bool crosses_itself = false;           ///< the surface, or its shells overlap
};

/// The solids of a rig's part; surface files are read and closed, and looked at along lines, two
/// hundred across, for places around which they wind other than once or not at all.
/// @throws InputError as `read_closed_surface`
[[nodiscard]] std::vector<SolidGeometry> read_solids(const Rig& rig);

/// Smallest box around all of them, of which there must be one [m].
[[nodiscard]] Box bounds_of(const std::vector<SolidGeometry>& solids);

/// "rigs/arm.toml: part 2 of 3 (box, material "part")".
[[nodiscard]] std::string describe_solid(const Rig& rig, int solid);

}  // namespace twang
