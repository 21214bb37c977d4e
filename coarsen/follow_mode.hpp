// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"

namespace twang {

/// A mode found again on another mesh.
struct FollowedMode {
  int mode = 0;           ///< of that mesh, from 0
  double affinity = 0.0;  ///< cosine between the shapes: 1 for the same one [-]
};
/// The mode of `other` that has the shape of mode `index` of `rung`, from 0: on another mesh modes
/// may change places, a thin strip's bending flatwise and edgewise for instance.
///
/// Shapes are compared at the nodes of `rung` (thinned out on large meshes), modes of near equal
/// frequencies as one family, whose members are then taken by their order. Both are meshes of one
/// part.
[[nodiscard]] FollowedMode follow_mode(const MeshRung& rung, int index, const MeshRung& other);

/// The Richardson limit of any mode of a ladder's reference meshes, followed by its shape.
/// @param mode  of the finest reference mesh, from 0
[[nodiscard]] RichardsonLimit limit_of_mode(const MeshLadder& ladder, int mode);

}  // namespace twang
