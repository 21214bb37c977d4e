// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"
#include "core/material.hpp"
#include "fem/static_solve.hpp"
#include "rigs/rig.hpp"

namespace twang {

/// Where the rig's gravity holds a mesh whose part has this material; undeformed without gravity.
/// @throws InputError if the materials of the mesh are more than one
[[nodiscard]] StaticResult sag_under_gravity(const Rig& rig,
                                             const MeshRung& rung,
                                             const ElasticMaterial& material);

/// Factor by which gravity changes an eigenvalue of a mesh at Young's modulus E:
///
///     lambda_k(K(u_sag); E) / (E lambda_k(K(0); 1 Pa))            1 without gravity [-]
///
/// A hanging beam is stiffened, a standing one softened, a drooping one turned.
/// @param mode  k - 1, of the mesh without gravity; with it, the mode of that shape is taken
/// @throws NumericalFailure if the part collapses under its own weight at that modulus
[[nodiscard]] double prestress_factor(const Rig& rig,
                                      const MeshRung& rung,
                                      const ElasticMaterial& material,
                                      int mode = 0);

/// Young's modulus at which a mesh vibrates with the target eigenvalue, its sag included: eq. (15)
/// iterated,
///
///     E <- lambda_t / (lambda_k prestress_factor(E)).
///
/// @param material         nu and rho of the part; its modulus is not used
/// @param unit_lambda_per_s2  lambda_k at E = 1 Pa without gravity, of this mesh or of the limit it
/// stands for [1/s²]
/// @param mode             k - 1, of this mesh
[[nodiscard]] double modulus_for_target(const Rig& rig,
                                        const MeshRung& rung,
                                        ElasticMaterial material,
                                        double unit_lambda_per_s2,
                                        double target_lambda_per_s2,
                                        int mode = 0);

}  // namespace twang
