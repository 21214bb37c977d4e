// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"
#include "core/material.hpp"
#include "rigs/rig.hpp"

#include <vector>

namespace twang {

/// What a film of the rig would have told of its coarse mesh, had the part the moduli that the rig
/// states: the coarse mesh is calibrated against the convergent one.
///
///     lambda_t = E lambda_1(limit),   E_n = E lambda_1(limit) / lambda_1(coarse) [paper, eq. (15)]
///
/// With gravity both meshes sag at their moduli (one material only). Of several materials all
/// moduli are rescaled alike. The uncertainty is that of the limit, of E_n in truth: E is stated.
///
/// @param ladder  of this rig
/// @param damping_stiffness_b_s  b of the file, which no mesh tells [s]
/// @return  one for each material of the part, in the order of the rig; frequency and decay are
/// those of the first mode, sigmas that only a film has are nan
/// @throws InputError if a material of the part states no youngs_modulus_pa, or gravity comes with
/// several materials, or b is negative; NumericalFailure as `modulus_for_target`
[[nodiscard]] std::vector<Material> measure_virtually(const Rig& rig,
                                                      const MeshLadder& ladder,
                                                      double damping_stiffness_b_s = 0.0);

}  // namespace twang
