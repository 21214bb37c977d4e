// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"
#include "core/damped_sinusoid.hpp"
#include "core/material.hpp"
#include "rigs/rig.hpp"

#include <vector>

namespace twang {

/// The eigenvalue and the damping that a tracked damped sinusoid stands for.
struct DampedTarget {
  double lambda_per_s2 = 0.0;
  double lambda_sigma_per_s2 = 0.0;
  double damping_stiffness_b_s = 0.0;
  double damping_stiffness_b_sigma_s = 0.0;
};
/// lambda_t = (2 pi f)² + d² and b = 2 d / lambda_t, the inverse of eq. (14) with a = 0, with
/// first-order sigmas in which cov(f, d) takes part; nan where the sinusoid's own sigmas are.
/// @throws InputError unless f >= 0, d >= 0 and lambda_t > 0
[[nodiscard]] DampedTarget damped_target(const DampedSinusoid& sinusoid);

/// f and d of a mode with eigenvalue lambda under D = a M + b K [paper, eq. (14)]; f = 0 when
/// overdamped.
struct FrequencyAndDecay {
  double frequency_hz = 0.0;
  double decay_per_s = 0.0;
};
[[nodiscard]] FrequencyAndDecay frequency_and_decay(double lambda_per_s2,
                                                    double a_per_s,
                                                    double b_s);

/// E_n = E_m lambda_t / lambda_1 [paper, eq. (15)] [Pa].
[[nodiscard]] double rescaled_modulus(double modulus_pa,
                                      double target_lambda_per_s2,
                                      double mesh_lambda_per_s2);

/// a and b of D = a M + b K, offered, never silently used.
struct RayleighFit {
  double damping_mass_a_per_s = 0.0;
  double damping_stiffness_b_s = 0.0;
};
/// a and b by least squares from two or more damped sinusoids, d = (a + b lambda) / 2, each
/// weighted by its decay's sigma where all of them are known.
/// @throws InputError with fewer than two different eigenvalues
[[nodiscard]] RayleighFit fit_rayleigh(const std::vector<DampedSinusoid>& sinusoids);

/// Relative sensitivities of the identified modulus, d ln E / d x = -d ln lambda_k / d x.
struct ModulusSensitivities {
  double dimension_per_m = 0.0;  ///< every outer face of the part moved outwards by half of it,
                                 ///< held nodes stay held: thickness [1/m]
  double poissons_ratio = 0.0;   ///< by nu [-]
  double density = 1.0;          ///< by ln rho; 1 exactly without added weights [-]
};
/// The sensitivities on one hex20 mesh whose topology is kept.
///
/// A mode shape makes its Rayleigh quotient stationary, so the first-order change of lambda_1 is
/// that of the quotient with the shape kept; it is taken by central differences, which need one
/// eigenproblem in all. The stairs of a voxelized curved face count along each axis, which makes
/// `dimension_per_m` an upper estimate there.
///
/// @param dx_m  cell size, that of an accurate rung of the ladder: a coarser mesh that locks
///              exaggerates the part of nu [m]
/// @param mode  whose eigenvalue was tracked, of that mesh, from 0
/// @throws InputError as `build_mesh_ladder`; NumericalFailure if the eigenproblem cannot be solved
[[nodiscard]] ModulusSensitivities modulus_sensitivities(const Rig& rig, double dx_m, int mode = 0);
/// The same on a mesh whose modes are known, at moduli of 1 Pa where the rig states none. On a mesh
/// that is not of voxels the outside moves along its own normals, and the inside follows smoothly.
/// @param rung  at least mode + 1 modes; hex20 for the reason above
[[nodiscard]] ModulusSensitivities modulus_sensitivities(const Rig& rig,
                                                         const MeshRung& rung,
                                                         int mode = 0);

/// The relative parts of sigma_E [contract of material.json]: statistical from (f, d), repeats,
/// mesh from the Richardson limit, and the rig's tolerances through the sensitivities (clock: twice
/// its relative error). A statistical part that is not known stays nan, and so does the total.
/// @param between_repeats_rel  relative standard error of lambda between repeats; 0 with one
[[nodiscard]] UncertaintyBudget modulus_budget(const DampedTarget& target,
                                               double mesh_relative_sigma,
                                               double between_repeats_rel,
                                               const Tolerance& tolerance,
                                               const ModulusSensitivities& sensitivities);

}  // namespace twang
