// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <string_view>

namespace twang {

enum class ConstitutiveModel { NeoHookean, SaintVenantKirchhoff, Linear };

/// The name a scene file uses: "neo_hookean", "stvk", "linear".
[[nodiscard]] std::string_view to_string(ConstitutiveModel model);
/// @throws InputError for any other name
[[nodiscard]] ConstitutiveModel constitutive_model_from(std::string_view name);

/// Lamé's constants from Young's modulus and Poisson's ratio.
struct LameConstants {
  double mu = 0.0;      ///< shear modulus E / (2 (1 + nu)) [Pa]
  double lambda = 0.0;  ///< E nu / ((1 + nu)(1 - 2 nu)) [Pa]
};
[[nodiscard]] LameConstants lame_constants(double youngs_modulus_pa, double poissons_ratio);

using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// Energy density [J/m³] at deformation gradient F; +infinity where det F <= 0 for the neo-Hookean
/// model.
///
///     neo-Hookean             psi = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)²
///     Saint Venant-Kirchhoff  psi = mu e:e + lambda/2 (tr e)²,  e = (F'F - I) / 2
///     linear                  psi = mu e:e + lambda/2 (tr e)²,  e = sym(F) - I
[[nodiscard]] double energy_density(ConstitutiveModel model,
                                    const LameConstants& lame,
                                    const Eigen::Matrix3d& F);
/// First Piola-Kirchhoff stress P = d psi / d F [Pa].
[[nodiscard]] Eigen::Matrix3d piola_stress(ConstitutiveModel model,
                                           const LameConstants& lame,
                                           const Eigen::Matrix3d& F);
/// d vec(P) / d vec(F), columns stacked, symmetric (9 x 9) [Pa].
[[nodiscard]] Matrix9d piola_tangent(ConstitutiveModel model,
                                     const LameConstants& lame,
                                     const Eigen::Matrix3d& F);

}  // namespace twang
