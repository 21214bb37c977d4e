// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"
#include "rigs/rig.hpp"

namespace twang {

/// Cell size at which the reference ladder starts: `start_dx_m`, else the thinnest wall of the
/// rig's solids, halved until every solid and clamp is caught; halved until borders of materials
/// fall on cell faces, if they do; doubled while the mesh is too large.
/// @throws InputError if no such size exists
[[nodiscard]] double starting_dx(const Rig& rig,
                                 const LadderOptions& options,
                                 std::vector<std::string>& notes);

/// Fills `reference`, `limit`, `convergent`, `accurate_rung` and notes of `ladder`.
void refine_reference(const Rig& rig,
                      double start_dx_m,
                      const LadderOptions& options,
                      MeshLadder& ladder);

/// The same from a mesh as it is, whose elements are cut into eight from rung to rung.
/// @param rig  with solids in place of the mesh file
void refine_file_reference(const Rig& rig,
                           HexMesh mesh,
                           const LadderOptions& options,
                           MeshLadder& ladder);

/// The limit of one mode: that of the finest rung; where hex20 ended on the same geometry, the one
/// less uncertain.
/// @param lambdas_per_s2  of that mode, one a rung
[[nodiscard]] RichardsonLimit limit_of(const std::vector<MeshRung>& reference,
                                       const std::vector<double>& lambdas_per_s2);

/// Fills `candidates`, `coarse`, `choice` and notes of `ladder`, whose reference stands.
void choose_mesh(const Rig& rig,
                 double start_dx_m,
                 const LadderOptions& options,
                 MeshLadder& ladder);

}  // namespace twang
