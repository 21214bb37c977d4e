// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"
#include "fem/hex_mesh.hpp"
#include "rigs/rig.hpp"

#include <vector>

namespace twang {

/// A weight at one point of a mesh.
struct WeightAtPoint {
  MeshPoint point;
  double mass_kg = 0.0;
};

/// A rig's weights at points of a mesh. One without a size lies where it lies, beside the mesh too;
/// one with a size is shared evenly by the points of a grid over its box that lie in the mesh: at
/// least four along each edge that has a length, and no farther apart than half a cell.
///
/// A solid gives way under a weight at one point without end as its cells become smaller; under a
/// weight with a size it does not.
/// @throws InputError if none of the mesh lies in a weight's box
[[nodiscard]] std::vector<WeightAtPoint> weights_at_points(const HexMesh& mesh,
                                                           const std::vector<PointMass>& weights);

/// Adds a rig's weights to a body.
/// @throws InputError as `weights_at_points`
void attach_weights(ElasticBody& body, const std::vector<PointMass>& weights);

}  // namespace twang
