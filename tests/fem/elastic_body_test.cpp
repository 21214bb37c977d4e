// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/elastic_body.hpp"

#include "core/constants.hpp"
#include "tests/fem/distorted_mesh.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/finite_differences.hpp"
#include "tests/support/rigs.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <string>
#include <tuple>

namespace twang {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::random_vector;

ElasticMaterial soft() {
  ElasticMaterial material = test::elastic(2.5, 0.3, 1.7);
  material.damping_stiffness_b_s = 0.04;
  return material;
}

/// Displacements u = (F - I) x + t at all nodes.
VectorXd affine(const HexMesh& mesh, const Matrix3d& F, const Vector3d& t = Vector3d::Zero()) {
  const Eigen::Matrix3Xd u = ((F - Matrix3d::Identity()) * mesh.nodes).colwise() + t;
  return u.reshaped();
}

Matrix3d skew(const Vector3d& axis) {
  Matrix3d result;
  result << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return result;
}

Matrix3d stretched() {
  Matrix3d F;
  F << 1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.1, 0.1, 1.2;
  return F;
}

using Case = std::tuple<ElementKind, ConstitutiveModel, bool>;

/// Every element and model, on congruent cells and on distorted ones, which are handled apart.
class EachBody : public ::testing::TestWithParam<Case> {
 protected:
  EachBody()
      : model(std::get<1>(GetParam())),
        body(test::distorted_mesh(std::get<0>(GetParam()), std::get<2>(GetParam()) ? 0.15 : 0.0),
             {soft()},
             model),
        u(random_vector(body.mesh().num_dofs(), 0.06, 5)),
        w(random_vector(body.mesh().num_dofs(), 1.0, 6)) {}

  ConstitutiveModel model;
  ElasticBody body;
  VectorXd u;  ///< a random state off rest
  VectorXd w;
};
INSTANTIATE_TEST_SUITE_P(
    ElasticBody,
    EachBody,
    ::testing::Combine(::testing::Values(ElementKind::Hex8, ElementKind::Hex20, ElementKind::Hex8e),
                       ::testing::Values(ConstitutiveModel::NeoHookean,
                                         ConstitutiveModel::SaintVenantKirchhoff,
                                         ConstitutiveModel::Linear),
                       ::testing::Bool()),
    [](const auto& at) {
      return std::string(to_string(std::get<0>(at.param))) + "_" +
             std::string(to_string(std::get<1>(at.param))) +
             (std::get<2>(at.param) ? "_distorted" : "_congruent");
    });

TEST_P(EachBody, PassesThePatchTest) {
  const Matrix3d F = stretched();
  const VectorXd affine_u = affine(body.mesh(), F, {0.3, -0.2, 0.7});
  const LameConstants lame = lame_constants(2.5, 0.3);
  const double energy = body.mesh().volume() * energy_density(model, lame, F);
  EXPECT_NEAR(body.elastic_energy(affine_u) / energy, 1.0, 1e-13);  // round-off
  const VectorXd force = body.internal_force(affine_u);
  const std::vector<int> inner = test::inner_nodes(body.mesh().kind);
  ASSERT_FALSE(inner.empty());
  for (const int n : inner) {
    EXPECT_LT(force.segment<3>(3 * n).norm(), 1e-13 * force.norm()) << "node " << n;
  }
}

TEST_P(EachBody, RigidMotionNeedsNoForce) {
  const Vector3d axis = Vector3d(1, -2, 0.5).normalized();
  // A linear body knows infinitesimal rotations alone.
  const Matrix3d R = model == ConstitutiveModel::Linear
                         ? Matrix3d(Matrix3d::Identity() + 0.1 * skew(axis))
                         : Eigen::AngleAxisd(1.3, axis).matrix();
  const VectorXd turned = affine(body.mesh(), R, {5.0, 1.0, -2.0});
  const double scale = body.internal_force(u).norm();
  EXPECT_LT(body.internal_force(turned).norm(), 1e-13 * scale);
  EXPECT_LT(body.elastic_energy(turned), 1e-13 * body.elastic_energy(u));
}

TEST_P(EachBody, ForceIsTheGradientOfTheEnergy) {
  const double slope = test::directional_derivative(
      [&](const VectorXd& x) { return body.elastic_energy(x); }, u, w, 1e-3);
  const double power = body.internal_force(u).dot(w);
  // Truncation of fourth order, (1e-3 / 0.1)⁴ = 1e-8 of the curvature's share, and less.
  EXPECT_NEAR(slope / power, 1.0, 1e-7);
}

TEST_P(EachBody, ProductIsTheDerivativeOfTheForce) {
  const VectorXd slope = test::directional_derivative(
      [&](const VectorXd& x) { return body.internal_force(x); }, u, w, 1e-3);
  EXPECT_LT((body.stiffness_product(u, w) - slope).norm(), 1e-6 * slope.norm());  // as above
}

TEST_P(EachBody, StiffnessIsTheMatrixOfTheProductAndSymmetric) {
  const SparseMatrix K = body.stiffness(u);
  const VectorXd product = body.stiffness_product(u, w);
  EXPECT_LT((K * w - product).norm(), 1e-14 * product.norm() * 10.0);  // round-off
  const SparseMatrix transposed = K.transpose();
  EXPECT_LT((K - transposed).norm(), 1e-15 * K.norm());
  const double b = soft().damping_stiffness_b_s;
  EXPECT_LT((body.stiffness_damping(u) - b * K).norm(), 1e-14 * b * K.norm());
  EXPECT_LT((body.stiffness_damping_force(u, w) - b * product).norm(), 1e-14 * b * product.norm());
}

TEST_P(EachBody, SmallDisplacementsLoseNoDigits) {
  const double small = 1e-9;
  const SparseMatrix K = body.stiffness({});
  const VectorXd force = body.internal_force(small * w);
  // What is left is the nonlinearity, of the order of the strain.
  EXPECT_LT((force - small * (K * w)).norm(), 20.0 * small * force.norm());
  const double energy = 0.5 * small * small * w.dot(K * w);
  EXPECT_NEAR(body.elastic_energy(small * w) / energy, 1.0, 20.0 * small);
}

TEST_P(EachBody, MassIsConsistent) {
  const SparseMatrix& M = body.mass();
  const VectorXd along_x = affine(body.mesh(), Matrix3d::Identity(), Vector3d::UnitX());
  const double mass = 1.7 * body.mesh().volume();
  EXPECT_NEAR(along_x.dot(M * along_x) / mass, 1.0, 1e-13);
  // A linear velocity field on undistorted cells: its energy is an integral of squares.
  if (!std::get<2>(GetParam())) {
    Matrix3d G = Matrix3d::Identity();
    G(0, 1) += 2.0;  // v_x = 2 y over a box 2 x 3 x 2: integral of 4 y² is 4 x 9 x 4
    const VectorXd v = affine(body.mesh(), G);
    EXPECT_NEAR(v.dot(M * v) / (1.7 * 4.0 * 36.0), 1.0, 1e-13);
  }
  const Vector3d g(0.5, -9.81, 2.0);
  const VectorXd weight = body.gravity_force(g);
  EXPECT_LT((weight.reshaped(3, body.mesh().num_nodes()).rowwise().sum() - mass * g).norm(),
            1e-13 * mass * g.norm());
}

TEST_P(EachBody, AddsItsMassToAStiffnessInPlace) {
  SparseMatrix A = body.stiffness(u);
  const SparseMatrix expected = A + 3.5 * body.mass();
  body.add_scaled_mass(3.5, A);
  EXPECT_EQ((A - expected).norm(), 0.0);
}

TEST(ElasticBody, EnergyIsInfiniteWhereAnElementIsInsideOut) {
  const ElasticBody body(test::distorted_mesh(ElementKind::Hex8, 0.1), {soft()});
  Matrix3d mirror = Matrix3d::Identity();
  mirror(2, 2) = -1.0;
  EXPECT_EQ(body.elastic_energy(affine(body.mesh(), mirror)), kInfinity);
}

TEST(ElasticBody, LargeStrainsAgreeWithTheConstitutiveModel) {
  // Beyond the range of the series of the logarithm: J from 0.1 to 9.
  const HexMesh mesh = test::distorted_mesh(ElementKind::Hex8, 0.1);
  const ElasticBody body(mesh, {soft()});
  for (const double stretch : {0.1, 0.5, 1.2, 9.0}) {
    Matrix3d F = Matrix3d::Identity();
    F(0, 0) = stretch;
    const double expected =
        mesh.volume() * energy_density(ConstitutiveModel::NeoHookean, lame_constants(2.5, 0.3), F);
    EXPECT_NEAR(body.elastic_energy(affine(mesh, F)) / expected, 1.0, 1e-13) << stretch;
  }
}

TEST(ElasticBody, WeighsEachMaterialByItsOwnConstants) {
  Rig rig = test::make_rig({Box{{0, 0, 0}, {2, 1, 1}}, Box{{2, 0, 0}, {3, 1, 1}}});
  rig.materials.push_back(rig.materials.front());
  rig.materials.back().name = "second";
  rig.parts.back().material = "second";
  const HexMesh mesh = mesh_part(rig, 0.5, ElementKind::Hex8);
  ElasticMaterial first = soft();
  ElasticMaterial second = test::elastic(10.0, 0.2, 3.0);
  second.damping_stiffness_b_s = 0.5;
  const ElasticBody both(mesh, {first, second});
  EXPECT_NEAR(both.gravity_force(Vector3d::UnitX()).sum(), 2.0 * 1.7 + 3.0, 1e-12);

  // The sum of two bodies, each with the other material so soft and light that it is not there.
  const ElasticMaterial nothing = test::elastic(1e-30, 0.2, 1e-30);
  const ElasticBody first_alone(mesh, {first, nothing});
  const ElasticBody second_alone(mesh, {nothing, second});
  const VectorXd u = random_vector(mesh.num_dofs(), 0.03, 1);
  const VectorXd v = random_vector(mesh.num_dofs(), 1.0, 2);
  const VectorXd force = first_alone.internal_force(u) + second_alone.internal_force(u);
  EXPECT_LT((both.internal_force(u) - force).norm(), 1e-14 * force.norm());
  const VectorXd damping =
      0.04 * first_alone.stiffness_product(u, v) + 0.5 * second_alone.stiffness_product(u, v);
  EXPECT_LT((both.stiffness_damping_force(u, v) - damping).norm(), 1e-14 * damping.norm());
  EXPECT_LT((both.stiffness_damping(u) * v - damping).norm(), 1e-13 * damping.norm());
}

TEST(ElasticBody, PointMassWeighsWhereItIsPut) {
  ElasticBody body(test::distorted_mesh(ElementKind::Hex20, 0.1), {soft()});
  const SparseMatrix before = body.mass();
  const MeshPoint point = locate(body.mesh(), {0.7, 1.1, 1.6});
  body.add_point_mass(point, 2.5);
  const VectorXd v = random_vector(body.mesh().num_dofs(), 1.0, 3);
  const double kinetic = 2.5 * interpolate(point, v).squaredNorm();
  EXPECT_NEAR((v.dot(body.mass() * v) - v.dot(before * v)) / kinetic, 1.0, 1e-12);
  const double weight = body.gravity_force(Vector3d::UnitZ()).sum();
  EXPECT_NEAR(weight, 2.5 + 1.7 * body.mesh().volume(), 1e-12);
  SparseMatrix A = body.stiffness({});
  const SparseMatrix expected = A + body.mass();
  body.add_scaled_mass(1.0, A);
  EXPECT_EQ((A - expected).norm(), 0.0);
}

TEST(ElasticBody, AnyNumberOfElementsFillsTheLanes) {
  // Batches hold four elements: all remainders occur.
  for (int count = 1; count <= 5; ++count) {
    const HexMesh mesh =
        mesh_part(test::make_rig({Box{{0, 0, 0}, {1.0 * count, 1, 1}}}), 1.0, ElementKind::Hex8);
    ASSERT_EQ(mesh.num_elements(), count);
    const ElasticBody body(mesh, {soft()});
    const Matrix3d F = stretched();
    const double expected =
        count * energy_density(ConstitutiveModel::NeoHookean, lame_constants(2.5, 0.3), F);
    EXPECT_NEAR(body.elastic_energy(affine(mesh, F)) / expected, 1.0, 1e-14);
  }
}

TEST(ElasticBody, RefusesWhatIsNotABody) {
  const HexMesh mesh = test::distorted_mesh(ElementKind::Hex8, 0.0);
  const auto refusal = [&](const std::vector<ElasticMaterial>& materials) {
    return test::refusal_of([&] { const ElasticBody body(mesh, materials); });
  };
  EXPECT_TRUE(test::holds(refusal({}), "0 materials"));
  EXPECT_TRUE(test::holds(refusal({test::elastic(0.0, 0.3, 1.0)}), "youngs_modulus_pa"));
  EXPECT_TRUE(test::holds(refusal({test::elastic(1.0, 0.5, 1.0)}), "poissons_ratio"));
  EXPECT_TRUE(test::holds(refusal({test::elastic(1.0, -1.0, 1.0)}), "poissons_ratio"));
  EXPECT_TRUE(test::holds(refusal({test::elastic(1.0, 0.3, -1.0)}), "density_kg_m3"));
  EXPECT_TRUE(test::holds(refusal({test::elastic(kNaN, 0.3, 1.0)}), "youngs_modulus_pa"));
  ElasticMaterial damped = soft();
  damped.damping_stiffness_b_s = -1.0;
  EXPECT_TRUE(test::holds(refusal({damped}), "damping_stiffness_b_s"));

  HexMesh inverted = mesh;
  inverted.elements.col(3).head<4>().swap(inverted.elements.col(3).tail<4>());
  EXPECT_TRUE(test::holds(test::refusal_of([&] { const ElasticBody body(inverted, {soft()}); }),
                          "element 3"));
  HexMesh dangling = mesh;
  dangling.elements(2, 1) = mesh.num_nodes();
  EXPECT_TRUE(test::holds(test::refusal_of([&] { const ElasticBody body(dangling, {soft()}); }),
                          "element 1"));
  const ElasticBody body(mesh, {soft()});
  EXPECT_TRUE(test::holds(test::refusal_of([&] { (void)body.internal_force(VectorXd::Zero(7)); }),
                          "7 entries"));
}

TEST(FreeDofs, RestrictAndExpandAreInverse) {
  const ElasticBody body(test::distorted_mesh(ElementKind::Hex8, 0.1), {soft()});
  const int num_nodes = body.mesh().num_nodes();
  const FreeDofs free(num_nodes, {0, 7, 3, 7});
  EXPECT_EQ(free.size(), 3 * (num_nodes - 3));
  EXPECT_EQ(free.held_dofs(), (std::vector<int>{0, 1, 2, 9, 10, 11, 21, 22, 23}));
  const VectorXd x = random_vector(free.size(), 1.0, 9);
  const VectorXd full = free.expand_vector(x);
  EXPECT_EQ(full.segment<3>(21), Vector3d::Zero());
  EXPECT_EQ(free.restrict_vector(full), x);
  const SparseMatrix K = body.stiffness({});
  const VectorXd product = free.restrict_vector(K * full);
  EXPECT_LT((free.restrict_matrix(K) * x - product).norm(), 1e-15 * product.norm() * 10.0);
}

TEST(FreeDofs, HoldsSingleDirectionsAndRefusesWhatIsNotThere) {
  const FreeDofs free = FreeDofs::from_held_dofs(2, {4});
  EXPECT_EQ(free.full_from_free(), (std::vector<int>{0, 1, 2, 3, 5}));
  EXPECT_TRUE(test::holds(test::refusal_of([] { (void)FreeDofs(2, {2}); }), "held node is 2"));
  EXPECT_TRUE(
      test::holds(test::refusal_of([] { (void)FreeDofs::from_held_dofs(2, {-1}); }), "is -1"));
}

}  // namespace
}  // namespace twang
