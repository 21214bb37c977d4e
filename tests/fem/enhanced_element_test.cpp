// SPDX-License-Identifier: GPL-3.0-or-later
// hex8e; what every element must do is tested in elastic_body_test.cpp.
#include "core/constants.hpp"
#include "core/dense_algebra.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/static_solve.hpp"
#include "tests/fem/distorted_mesh.hpp"
#include "tests/support/rigs.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A slab 20 x 2 x 1, clamped at x = 0, of cells one unit high.
Rig slab_rig() { return test::make_rig({Box{{0, 0, 0}, {20, 2, 1}}}, {Box{{0, 0, 0}, {0, 2, 1}}}); }

/// Mean displacement of its end under a force along z, by that of a beam.
double end_deflection(ElementKind kind, double nu, double force_n, ConstitutiveModel model) {
  const HexMesh mesh = mesh_part(slab_rig(), 1.0, kind);
  const ElasticBody body(mesh, {test::elastic(1.0, nu, 1.0)}, model);
  std::vector<int> end;
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    if (mesh.nodes(0, n) > 20.0 - 1e-9) end.push_back(n);
  }
  StaticLoad load;
  load.force = VectorXd::Zero(mesh.num_dofs());
  for (const int n : end) load.force[3 * n + 2] = force_n / static_cast<double>(end.size());
  const StaticResult result = solve_static(body, clamped_nodes(mesh, slab_rig()), load);
  EXPECT_TRUE(result.usable()) << result.message;
  double deflection = 0.0;
  for (const int n : end) deflection += result.u[3 * n + 2] / static_cast<double>(end.size());
  return deflection;
}

constexpr double kBendingStiffness = 2.0 / 12.0;  // E I of the slab

TEST(EnhancedElement, BendsAsABeamWhereHex8LocksOneCellThick) {
  const double force = 1e-7;
  const auto of_beam = [&](ElementKind kind, double nu) {
    const double bending = force * 8000.0 / (3.0 * kBendingStiffness);
    return end_deflection(kind, nu, force, ConstitutiveModel::Linear) / bending;
  };
  // Shear adds 0.2 %, the clamp's grip on the cross section takes up to 4 % off at nu 0.5.
  EXPECT_NEAR(of_beam(ElementKind::Hex8e, 0.0), 1.0, 0.004);
  EXPECT_NEAR(of_beam(ElementKind::Hex8e, 0.3), 1.0, 0.02);
  const double nearly = of_beam(ElementKind::Hex8e, 0.499);
  EXPECT_NEAR(nearly, 1.0, 0.05);
  // No locking: the limit of nu changes nothing any more.
  EXPECT_NEAR(of_beam(ElementKind::Hex8e, 0.499999) / nearly, 1.0, 2e-3);
  EXPECT_LT(of_beam(ElementKind::Hex8, 0.0), 0.7);
  EXPECT_LT(of_beam(ElementKind::Hex8, 0.499), 0.4);
}

TEST(EnhancedElement, FollowsTheElasticaOneCellThick) {
  // P L² / (E I) = 2: w / L = 0.49346 [Bisshopp & Drucker 1945].
  const double force = 2.0 * kBendingStiffness / 400.0;
  const double w = end_deflection(ElementKind::Hex8e, 0.0, force, ConstitutiveModel::NeoHookean);
  EXPECT_NEAR(w / 20.0 / 0.49346, 1.0, 0.01);  // 20 cells along it, and strains of 2 %
}

TEST(EnhancedElement, HasSixZeroEigenvaluesAndNoMore) {
  for (const double distortion : {0.0, 0.2}) {
    const HexMesh all = test::distorted_mesh(ElementKind::Hex8e, distortion);
    for (int e = 0; e < all.num_elements(); ++e) {
      HexMesh one = all;
      one.nodes.resize(3, 8);
      one.elements.resize(8, 1);
      for (int a = 0; a < 8; ++a) {
        one.nodes.col(a) = all.nodes.col(all.elements(a, e));
        one.elements(a, 0) = a;
      }
      one.material_of_element.resize(1);
      for (const double nu : {0.0, 0.3, 0.499}) {
        const ElasticBody body(one, {test::elastic(1.0, nu, 1.0)});
        const VectorXd values = symmetric_eigen(Eigen::MatrixXd(body.stiffness({}))).values;
        EXPECT_LT(values.head(6).cwiseAbs().maxCoeff(), 1e-12 * values[23]);  // round-off
        // The softest of 18 strains is an hourglass, 0.05 E of a unit cube.
        EXPECT_GT(values[6], 0.01) << "element " << e << ", nu " << nu;
      }
    }
  }
}

TEST(EnhancedElement, StandsCompressionToATenth) {
  const HexMesh mesh = test::distorted_mesh(ElementKind::Hex8e, 0.15);
  const ElasticBody body(mesh, {test::elastic(2.5, 0.45, 1.0)});
  for (const double c : {0.7, 0.3, 0.1}) {
    const Matrix3d F = Vector3d(c, 1.0, 1.0).asDiagonal();
    const VectorXd u = ((F - Matrix3d::Identity()) * mesh.nodes).reshaped();
    const double energy =
        energy_density(ConstitutiveModel::NeoHookean, lame_constants(2.5, 0.45), F);
    EXPECT_NEAR(body.elastic_energy(u) / (mesh.volume() * energy), 1.0, 1e-12);  // round-off
  }
  const Matrix3d inside_out = Vector3d(-0.1, 1.0, 1.0).asDiagonal();
  const VectorXd u = ((inside_out - Matrix3d::Identity()) * mesh.nodes).reshaped();
  EXPECT_EQ(body.elastic_energy(u), kInfinity);
}

TEST(EnhancedElement, InternalModesAreAtTheMinimumUnderLargeDeformation) {
  // Bent by 90 degrees with bulging sides: force and tangent stay the derivatives of the energy.
  const HexMesh mesh =
      mesh_part(test::make_rig({Box{{0, 0, 0}, {4, 1, 1}}}), 1.0, ElementKind::Hex8e);
  const ElasticBody body(mesh, {test::elastic(2.5, 0.45, 1.0)});
  VectorXd u(mesh.num_dofs());
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    const Vector3d x = mesh.nodes.col(n);
    const double angle = 0.5 * kPi * x.x() / 4.0;
    const double radius = 8.0 / kPi + x.z();
    u.segment<3>(3 * n) = Vector3d(radius * std::sin(angle), x.y(), radius * std::cos(angle)) - x;
  }
  u += test::random_vector(mesh.num_dofs(), 0.05, 3);
  const VectorXd w = test::random_vector(mesh.num_dofs(), 1.0, 4);
  const double slope = test::directional_derivative(
      [&](const VectorXd& x) { return body.elastic_energy(x); }, u, w, 1e-4);
  EXPECT_NEAR(slope / body.internal_force(u).dot(w), 1.0, 1e-8);  // (1e-4 / 0.05)⁴ and round-off
  const VectorXd change = test::directional_derivative(
      [&](const VectorXd& x) { return body.internal_force(x); }, u, w, 1e-4);
  EXPECT_LT((change - body.stiffness(u) * w).norm(), 1e-8 * change.norm());
}

/// A bar of hex8e, 4 x 4 x 8, between two plates that are `squeeze` of its length nearer.
struct SqueezedBar {
  HexMesh mesh = mesh_part(test::make_rig({Box{{0, 0, 0}, {4, 4, 8}}}), 1.0, ElementKind::Hex8e);
  ElasticBody body;
  std::vector<int> held;
  VectorXd u;

  SqueezedBar(ConstitutiveModel model, double squeeze)
      : body(mesh, {test::elastic(1.0, 0.3, 1.0)}, model) {
    for (int n = 0; n < mesh.num_nodes(); ++n) {
      if (mesh.nodes(2, n) < 1e-9 || mesh.nodes(2, n) > 8.0 - 1e-9) held.push_back(n);
    }
    const Matrix3d gradient = Vector3d(0.0, 0.0, -squeeze).asDiagonal();
    u = (gradient * mesh.nodes).reshaped();
  }
};

TEST(EnhancedElement, OfSaintVenantKirchhoffBucklesUnderStrongCompressionAndThatIsSaid) {
  const SqueezedBar soft(ConstitutiveModel::SaintVenantKirchhoff, 0.3);
  const StaticResult buckled = solve_static(soft.body, soft.held, {}, {}, soft.u);
  EXPECT_FALSE(buckled.stable);
  EXPECT_NE(buckled.message.find("not a stable one"), std::string::npos) << buckled.message;
  const Eigenmodes modes = compute_eigenmodes(soft.body, soft.held, {}, soft.u);
  ASSERT_TRUE(modes.usable()) << modes.message;
  EXPECT_GT(modes.num_unstable, 0);
  EXPECT_NE(modes.message.find("negative"), std::string::npos) << modes.message;

  const SqueezedBar sound(ConstitutiveModel::NeoHookean, 0.3);
  const StaticResult balanced = solve_static(sound.body, sound.held, {}, {}, sound.u);
  EXPECT_TRUE(balanced.usable()) << balanced.message;
  EXPECT_TRUE(balanced.stable) << balanced.message;
  EXPECT_EQ(compute_eigenmodes(sound.body, sound.held, {}, balanced.u).num_unstable, 0);
}

TEST(EnhancedElement, OfSaintVenantKirchhoffCollapsesWhenSqueezedToHalfAndThatIsSaid) {
  const SqueezedBar collapsed(ConstitutiveModel::SaintVenantKirchhoff, 0.5);
  const StaticResult squeezed = solve_static(collapsed.body, collapsed.held, {}, {}, collapsed.u);
  EXPECT_FALSE(squeezed.usable());
  EXPECT_NE(squeezed.message.find("collapse"), std::string::npos) << squeezed.message;
  const Eigenmodes modes = compute_eigenmodes(collapsed.body, collapsed.held, {}, collapsed.u);
  EXPECT_FALSE(modes.usable());
  EXPECT_NE(modes.message.find("collapse"), std::string::npos) << modes.message;
}

}  // namespace
}  // namespace twang
