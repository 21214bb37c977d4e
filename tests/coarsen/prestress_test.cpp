// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/prestress.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

constexpr double kSide_m = 0.01;
constexpr double kLength_m = 0.2;
constexpr double kGravity_m_s2 = 9.81;

/// A slender square column along z, held at its foot.
Rig column(double gravity_z_m_s2) {
  Rig rig;
  rig.name = "column";
  rig.materials.push_back({"part", 1000.0, 0.0, {}, {}});
  rig.parts.push_back({"part", Box{{0.0, 0.0, 0.0}, {kSide_m, kSide_m, kLength_m}}});
  rig.clamps.push_back(Box{{0.0, 0.0, 0.0}, {kSide_m, kSide_m, 0.0}});
  if (gravity_z_m_s2 != 0.0) rig.gravity_m_s2 = Eigen::Vector3d(0.0, 0.0, gravity_z_m_s2);
  return rig;
}

ElasticMaterial soft() {
  ElasticMaterial material;
  material.youngs_modulus_pa = 1.2e7;
  material.density_kg_m3 = 1000.0;
  return material;
}

/// Greenhill's column buckles under its own weight q at q L³ = 7.837 E I; below, lambda falls in
/// proportion (to within a few per cent of the change, the mode being nearly that of buckling).
double greenhill_change() {
  const double second_moment = std::pow(kSide_m, 4) / 12.0;
  const double weight_per_length = 1000.0 * kGravity_m_s2 * kSide_m * kSide_m;
  return weight_per_length * std::pow(kLength_m, 3) /
         (7.837 * soft().youngs_modulus_pa * second_moment);
}

class Prestress : public testing::TestWithParam<double> {};

TEST_P(Prestress, ChangesTheEigenvalueOfAColumnAsGreenhillSays) {
  const Rig rig = column(GetParam());
  const MeshRung rung = compute_rung(rig, kSide_m, ElementKind::Hex20, 2);
  const double expected = GetParam() > 0.0 ? greenhill_change() : -greenhill_change();
  // a tenth of the change: the two mode shapes differ
  EXPECT_NEAR(prestress_factor(rig, rung, soft()) - 1.0, expected, 0.1 * std::abs(expected));
}

INSTANTIATE_TEST_SUITE_P(HangingAndStanding,
                         Prestress,
                         testing::Values(kGravity_m_s2, -kGravity_m_s2));

TEST(Prestress, IsOneWithoutGravity) {
  const Rig rig = column(0.0);
  const MeshRung rung = compute_rung(rig, kSide_m, ElementKind::Hex20, 2);
  EXPECT_EQ(prestress_factor(rig, rung, soft()), 1.0);
}

TEST(Prestress, IsTakenOutOfTheModulus) {
  const Rig rig = column(-kGravity_m_s2);
  const MeshRung rung = compute_rung(rig, kSide_m, ElementKind::Hex20, 2);
  const double unit_lambda = rung.modes.lambda_per_s2[0];
  const double target =
      soft().youngs_modulus_pa * unit_lambda * prestress_factor(rig, rung, soft());
  // the iteration stops at 1e-5
  EXPECT_NEAR(modulus_for_target(rig, rung, soft(), unit_lambda, target) / soft().youngs_modulus_pa,
              1.0,
              3e-5);
}

TEST(Sag, ShortensAStandingColumnByItsWeight) {
  const Rig rig = column(-kGravity_m_s2);
  const MeshRung rung = compute_rung(rig, kSide_m, ElementKind::Hex20, 2);
  const StaticResult sag = sag_under_gravity(rig, rung, soft());
  ASSERT_TRUE(sag.usable()) << sag.message;
  const double shortening =
      1000.0 * kGravity_m_s2 * kLength_m * kLength_m / (2.0 * soft().youngs_modulus_pa);
  double lowest = 0.0;
  for (int node = 0; node < rung.mesh.num_nodes(); ++node)
    lowest = std::min(lowest, sag.u[3 * node + 2]);
  // strains of 1e-4: the nonlinear answer differs by as much
  EXPECT_NEAR(lowest / -shortening, 1.0, 0.01);
}

}  // namespace
}  // namespace twang
