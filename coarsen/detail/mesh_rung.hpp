// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"
#include "core/progress.hpp"
#include "fem/attach_weights.hpp"
#include "fem/elastic_body.hpp"
#include "fem/hex_mesh.hpp"
#include "rigs/rig.hpp"

#include <string>
#include <vector>

namespace twang {

/// A copy of `rig` as its ladder is computed: if the part has one material, that has no stated
/// modulus, so that every rung is computed at 1 Pa and eigenvalues are proportional to E; of
/// several materials all keep what they state.
/// @param notes  gets a sentence if a stated modulus is left out
/// @throws InputError if the rig lacks part or clamp, or one of several materials states no
/// modulus: then eq. (15) cannot tell them apart
[[nodiscard]] Rig rig_to_identify(const Rig& rig, std::vector<std::string>& notes);

/// Whether the rig's solids are of more than one material.
[[nodiscard]] bool has_several_materials(const Rig& rig);

/// `compute_rung` for a ladder: voxel meshes of hex8 and hex8e go to the multigrid where it begins
/// to be the faster way, long before a factor is too large for the memory.
[[nodiscard]] MeshRung compute_ladder_rung(
    const Rig& rig, double dx_m, ElementKind kind, int num_modes, const ProgressCallback& progress);

/// The same of a mesh that stands.
[[nodiscard]] MeshRung compute_ladder_rung(const Rig& rig,
                                           HexMesh mesh,
                                           int num_modes,
                                           const ProgressCallback& progress);

/// A rig's linear body with its weights.
[[nodiscard]] ElasticBody linear_body(const HexMesh& mesh,
                                      const std::vector<ElasticMaterial>& materials,
                                      const std::vector<WeightAtPoint>& weights);

/// Unknowns that a mesh of `kind` would have, held ones included, without building it as hex20.
///
/// On voxels the number of edges follows from Euler's V - E + F - C = 1.
///
/// @throws InputError as `mesh_part`
[[nodiscard]] long count_dofs(const Rig& rig, double dx_m, ElementKind kind);

/// "1.5 mm".
[[nodiscard]] std::string millimetres(double length_m);
/// "hex20 at 1.5 mm".
[[nodiscard]] std::string describe(const HexMesh& mesh);

}  // namespace twang
