// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/constitutive.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <cmath>

namespace twang {
namespace {

using Eigen::Matrix3d;

Matrix3d small_strain(const Matrix3d& F) {
  return 0.5 * (F + F.transpose()) - Matrix3d::Identity();
}

Matrix3d green_strain(const Matrix3d& F) {
  return 0.5 * (F.transpose() * F - Matrix3d::Identity());
}

/// 2 mu e + lambda tr(e) I
Matrix3d isotropic_stress(const LameConstants& lame, const Matrix3d& strain) {
  return 2.0 * lame.mu * strain + lame.lambda * strain.trace() * Matrix3d::Identity();
}

/// mu e:e + lambda/2 (tr e)²
double isotropic_energy(const LameConstants& lame, const Matrix3d& strain) {
  const double trace = strain.trace();
  return lame.mu * strain.squaredNorm() + 0.5 * lame.lambda * trace * trace;
}

Matrix3d neo_hookean_differential(const LameConstants& lame,
                                  const Matrix3d& F,
                                  const Matrix3d& dF) {
  const Matrix3d inverse = F.inverse();
  const double log_j = std::log(F.determinant());
  return lame.mu * dF + (lame.mu - lame.lambda * log_j) * (inverse * dF * inverse).transpose() +
         lame.lambda * (inverse * dF).trace() * inverse.transpose();
}

Matrix3d saint_venant_kirchhoff_differential(const LameConstants& lame,
                                             const Matrix3d& F,
                                             const Matrix3d& dF) {
  const Matrix3d dE = 0.5 * (dF.transpose() * F + F.transpose() * dF);
  return dF * isotropic_stress(lame, green_strain(F)) + F * isotropic_stress(lame, dE);
}

Matrix3d piola_differential(ConstitutiveModel model,
                            const LameConstants& lame,
                            const Matrix3d& F,
                            const Matrix3d& dF) {
  switch (model) {
    case ConstitutiveModel::NeoHookean:
      return neo_hookean_differential(lame, F, dF);
    case ConstitutiveModel::SaintVenantKirchhoff:
      return saint_venant_kirchhoff_differential(lame, F, dF);
    case ConstitutiveModel::Linear:
      break;
  }
  return isotropic_stress(lame, 0.5 * (dF + dF.transpose()));
}

}  // namespace

std::string_view to_string(ConstitutiveModel model) {
  switch (model) {
    case ConstitutiveModel::NeoHookean:
      return "neo_hookean";
    case ConstitutiveModel::SaintVenantKirchhoff:
      return "stvk";
    case ConstitutiveModel::Linear:
      break;
  }
  return "linear";
}

ConstitutiveModel constitutive_model_from(std::string_view name) {
  for (const ConstitutiveModel model : {ConstitutiveModel::NeoHookean,
                                        ConstitutiveModel::SaintVenantKirchhoff,
                                        ConstitutiveModel::Linear}) {
    if (name == to_string(model)) return model;
  }
  throw InputError(
      fmt::format("model is \"{}\", must be \"neo_hookean\", \"stvk\" or \"linear\"", name));
}

LameConstants lame_constants(double youngs_modulus_pa, double poissons_ratio) {
  const double E = youngs_modulus_pa;
  const double nu = poissons_ratio;
  return {E / (2.0 * (1.0 + nu)), E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))};
}

double energy_density(ConstitutiveModel model, const LameConstants& lame, const Matrix3d& F) {
  switch (model) {
    case ConstitutiveModel::NeoHookean: {
      const double J = F.determinant();
      if (!(J > 0.0)) return kInfinity;
      const double log_j = std::log(J);
      return lame.mu * (0.5 * (F.squaredNorm() - 3.0) - log_j) + 0.5 * lame.lambda * log_j * log_j;
    }
    case ConstitutiveModel::SaintVenantKirchhoff:
      return isotropic_energy(lame, green_strain(F));
    case ConstitutiveModel::Linear:
      break;
  }
  return isotropic_energy(lame, small_strain(F));
}

Matrix3d piola_stress(ConstitutiveModel model, const LameConstants& lame, const Matrix3d& F) {
  switch (model) {
    case ConstitutiveModel::NeoHookean: {
      const double log_j = std::log(F.determinant());
      return lame.mu * F + (lame.lambda * log_j - lame.mu) * F.inverse().transpose();
    }
    case ConstitutiveModel::SaintVenantKirchhoff:
      return F * isotropic_stress(lame, green_strain(F));
    case ConstitutiveModel::Linear:
      break;
  }
  return isotropic_stress(lame, small_strain(F));
}

Matrix9d piola_tangent(ConstitutiveModel model, const LameConstants& lame, const Matrix3d& F) {
  Matrix9d tangent;
  for (int column = 0; column < 9; ++column) {
    Matrix3d dF = Matrix3d::Zero();
    dF(column % 3, column / 3) = 1.0;
    const Matrix3d dP = piola_differential(model, lame, F, dF);
    tangent.col(column) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(dP.data());
  }
  return tangent;
}

}  // namespace twang
