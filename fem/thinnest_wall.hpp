// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

namespace twang {

/// Thickness of the thinnest walls of a rig's solids, what a cell size may begin with: the smallest
/// edge of boxes, diameter and length of cylinders; of a surface the length that one in fifty of
/// the pieces does not reach into which lines along an axis are cut by it, for the axis where that
/// is least [m].
/// @throws InputError if there is no solid, or a surface file cannot be used
[[nodiscard]] double thinnest_wall_m(const Rig& rig);

}  // namespace twang
