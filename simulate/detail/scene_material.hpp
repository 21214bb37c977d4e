// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/material.hpp"
#include "fem/hex_mesh.hpp"
#include "simulate/scene.hpp"

#include <vector>

namespace twang::detail {

/// The materials of a body's mesh, in its order.
/// @throws InputError if they come from a file whose E_n belongs to another mesh, or that lacks the
/// modulus wanted
[[nodiscard]] std::vector<ElasticMaterial> scene_materials(const SceneBody& body,
                                                           const HexMesh& mesh);

}  // namespace twang::detail
