// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/constitutive.hpp"

#include "core/constants.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/finite_differences.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <string>

namespace twang {
namespace {

using Eigen::Matrix3d;
using Eigen::VectorXd;

constexpr LameConstants kLame{0.7, 1.9};
// Central differences of fourth order with this step leave about step⁴ + round-off / step = 1e-12.
constexpr double kStep = 1e-3;
constexpr double kDifferenceError = 1e-10;

Matrix3d as_matrix(const VectorXd& entries) { return Eigen::Map<const Matrix3d>(entries.data()); }

VectorXd as_vector(const Matrix3d& matrix) {
  return Eigen::Map<const Eigen::Matrix<double, 9, 1>>(matrix.data());
}

/// A stretch and turn well off the rest state, det F > 0.
Matrix3d deformed() { return Matrix3d::Identity() + as_matrix(test::random_vector(9, 0.35, 4)); }

class EachModel : public ::testing::TestWithParam<ConstitutiveModel> {};
INSTANTIATE_TEST_SUITE_P(Constitutive,
                         EachModel,
                         ::testing::Values(ConstitutiveModel::NeoHookean,
                                           ConstitutiveModel::SaintVenantKirchhoff,
                                           ConstitutiveModel::Linear),
                         [](const auto& model) { return std::string(to_string(model.param)); });

TEST_P(EachModel, StressIsTheDerivativeOfTheEnergy) {
  const Matrix3d F = deformed();
  const Matrix3d P = piola_stress(GetParam(), kLame, F);
  for (int i = 0; i < 9; ++i) {
    const double slope = test::directional_derivative(
        [&](const VectorXd& x) { return energy_density(GetParam(), kLame, as_matrix(x)); },
        as_vector(F),
        VectorXd::Unit(9, i),
        kStep);
    EXPECT_NEAR(P(i % 3, i / 3), slope, kDifferenceError);
  }
}

TEST_P(EachModel, TangentIsTheDerivativeOfTheStressAndSymmetric) {
  const Matrix3d F = deformed();
  const Matrix9d tangent = piola_tangent(GetParam(), kLame, F);
  for (int i = 0; i < 9; ++i) {
    const VectorXd slope = test::directional_derivative(
        [&](const VectorXd& x) { return as_vector(piola_stress(GetParam(), kLame, as_matrix(x))); },
        as_vector(F),
        VectorXd::Unit(9, i),
        kStep);
    EXPECT_LT((tangent.col(i) - slope).cwiseAbs().maxCoeff(), kDifferenceError);
  }
  EXPECT_LT((tangent - tangent.transpose()).cwiseAbs().maxCoeff(), 1e-14);  // round-off
}

TEST_P(EachModel, RestStateIsFreeOfStressAndHasTheLinearTangent) {
  const Matrix3d I = Matrix3d::Identity();
  EXPECT_EQ(energy_density(GetParam(), kLame, I), 0.0);
  EXPECT_EQ(piola_stress(GetParam(), kLame, I), Matrix3d::Zero());
  const Matrix9d linear = piola_tangent(ConstitutiveModel::Linear, kLame, I);
  const Matrix9d difference = piola_tangent(GetParam(), kLame, I) - linear;
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-15);  // round-off
}

TEST(Constitutive, NonlinearEnergiesDoNotSeeRotations) {
  const Matrix3d F = deformed();
  const Matrix3d R = Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, 2, -1).normalized()).matrix();
  for (const auto model :
       {ConstitutiveModel::NeoHookean, ConstitutiveModel::SaintVenantKirchhoff}) {
    EXPECT_NEAR(energy_density(model, kLame, R * F), energy_density(model, kLame, F), 1e-14);
  }
  EXPECT_GT(energy_density(ConstitutiveModel::Linear, kLame, R * F),
            10.0 * energy_density(ConstitutiveModel::Linear, kLame, F));
}

TEST(Constitutive, UniaxialStressGivesBackTheTwoConstants) {
  const double E = 3.1e9;
  const double nu = 0.37;
  const LameConstants lame = lame_constants(E, nu);
  const double strain = 1e-3;
  const Matrix3d F =
      Matrix3d::Identity() + strain * Eigen::Vector3d(1.0, -nu, -nu).asDiagonal().toDenseMatrix();
  const Matrix3d P = piola_stress(ConstitutiveModel::Linear, lame, F);
  // Round-off of F - I, 1e-16, over the strain.
  EXPECT_NEAR(P(0, 0) / (E * strain), 1.0, 1e-12);
  EXPECT_NEAR(P(1, 1) / (E * strain), 0.0, 1e-12);
}

TEST(Constitutive, NeoHookeanEnergyIsInfiniteInsideOut) {
  Matrix3d F = Matrix3d::Identity();
  F(1, 1) = -0.1;
  EXPECT_EQ(energy_density(ConstitutiveModel::NeoHookean, kLame, F), kInfinity);
  F(1, 1) = 0.0;
  EXPECT_EQ(energy_density(ConstitutiveModel::NeoHookean, kLame, F), kInfinity);
}

TEST(Constitutive, ModelNamesReadBackAndOthersAreRefused) {
  EXPECT_EQ(constitutive_model_from("neo_hookean"), ConstitutiveModel::NeoHookean);
  EXPECT_EQ(constitutive_model_from("stvk"), ConstitutiveModel::SaintVenantKirchhoff);
  EXPECT_EQ(constitutive_model_from("linear"), ConstitutiveModel::Linear);
  const std::string message = test::refusal_of([] { (void)constitutive_model_from("ogden"); });
  EXPECT_TRUE(test::holds(message, "\"ogden\""));
}

}  // namespace
}  // namespace twang
