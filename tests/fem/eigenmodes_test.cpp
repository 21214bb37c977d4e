// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/eigenmodes.hpp"

#include "core/constants.hpp"
#include "fem/detail/rigid_modes.hpp"
#include "fem/linear_solver.hpp"
#include "tests/fem/distorted_mesh.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/rigs.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::make_rig;

EigenmodeOptions wanted(int count) {
  EigenmodeOptions options;
  options.count = count;
  return options;
}

/// A bar along x of `cells` unit cells.
Rig bar_rig(int cells) {
  return make_rig({Box{{0, 0, 0}, {1.0 * cells, 1, 1}}}, {Box{{0, 0, 0}, {0, 1, 1}}});
}

/// M-orthonormality and the residual, which any set of modes must have.
void expect_true_modes(const ElasticBody& body, const Eigenmodes& modes) {
  ASSERT_TRUE(modes.usable()) << modes.message;
  const MatrixXd gram = modes.shapes.transpose() * (body.mass() * modes.shapes);
  // Round-off of the Lanczos basis, grown by the conditioning of the stiffness.
  EXPECT_LT((gram - MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(), 1e-9);
  // ‖K phi‖ itself carries round-off of largest over smallest eigenvalue, 1e-16 x 1e9.
  EXPECT_LT(modes.max_residual, 1e-6);
  for (int k = 1; k < modes.count(); ++k) {
    EXPECT_GE(modes.lambda_per_s2[k], modes.lambda_per_s2[k - 1]);
  }
}

TEST(Eigenmodes, AxialBarHasTheExactDiscreteFrequencies) {
  // Linear elements with consistent mass on a bar of n cells, clamped at one end:
  // lambda = 6 (c / h)² (1 - cos k h) / (2 + cos k h), k = (m - 1/2) pi / (n h).
  const int cells = 60;
  const HexMesh mesh = mesh_part(bar_rig(cells), 1.0, ElementKind::Hex8);
  std::vector<int> held;
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    if (mesh.nodes(0, n) == 0.0) held.push_back(3 * n);
    held.push_back(3 * n + 1);
    held.push_back(3 * n + 2);
  }
  const ElasticBody body(mesh, {test::elastic(5.0, 0.0, 2.0)});
  const Eigenmodes modes =
      compute_eigenmodes(body, FreeDofs::from_held_dofs(mesh.num_nodes(), held), wanted(6));
  expect_true_modes(body, modes);
  for (int m = 1; m <= 6; ++m) {
    const double kh = (m - 0.5) * kPi / cells;
    const double lambda = 6.0 * 2.5 * (1.0 - std::cos(kh)) / (2.0 + std::cos(kh));
    EXPECT_NEAR(modes.lambda_per_s2[m - 1] / lambda, 1.0, 1e-9) << m;
    EXPECT_NEAR(modes.natural_frequency_hz(m - 1) / (std::sqrt(lambda) / kTwoPi), 1.0, 1e-9);
  }
}

TEST(Eigenmodes, FreeBodyHasSixZeroModes) {
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20, ElementKind::Hex8e}) {
    const ElasticBody body(test::distorted_mesh(kind, 0.1), {test::elastic(3.0, 0.3, 1.0)});
    const Eigenmodes modes = compute_eigenmodes(body, {}, wanted(8));
    expect_true_modes(body, modes);
    for (int k = 0; k < 6; ++k) EXPECT_EQ(modes.lambda_per_s2[k], 0.0);
    EXPECT_GT(modes.lambda_per_s2[6], 0.1);
  }
}

TEST(Eigenmodes, HeldNodesLeaveTheRotationsAboutThem) {
  const ElasticBody body(test::distorted_mesh(ElementKind::Hex20, 0.1),
                         {test::elastic(3.0, 0.3, 1.0)});
  const auto num_zero = [&](const std::vector<int>& held) {
    const Eigenmodes modes = compute_eigenmodes(body, held, wanted(8));
    expect_true_modes(body, modes);
    EXPECT_GT(modes.lambda_per_s2[6], 1e-3);
    return (modes.lambda_per_s2.array() == 0.0).count();
  };
  EXPECT_EQ(num_zero({}), 6);
  EXPECT_EQ(num_zero({5}), 3);
  EXPECT_EQ(num_zero({5, 40}), 1);
  EXPECT_EQ(num_zero({5, 40, 70}), 0);
}

TEST(Eigenmodes, ASingleElementHasAllItsModes) {
  // All 24 modes of a single element.
  const ElasticBody one(mesh_part(bar_rig(1), 1.0, ElementKind::Hex8),
                        {test::elastic(3.0, 0.3, 1.0)});
  const Eigenmodes all = compute_eigenmodes(one, {}, wanted(24));
  expect_true_modes(one, all);
  EXPECT_EQ((all.lambda_per_s2.array() == 0.0).count(), 6);
  const MatrixXd K = one.stiffness({});
  const double trace = (all.shapes.transpose() * K * all.shapes).trace();
  EXPECT_NEAR(all.lambda_per_s2.sum() / trace, 1.0, 1e-10);
}

TEST(Eigenmodes, FindsBothBendingsOfASquareBar) {
  for (const int count : {4, 5, 6}) {
    const Rig rig = make_rig({Box{{0, 0, 0}, {12, 2, 2}}}, {Box{{0, 0, 0}, {0, 2, 2}}});
    const HexMesh mesh = mesh_part(rig, 1.0, ElementKind::Hex20);
    const ElasticBody body(mesh, {test::elastic(3.0, 0.3, 1.0)});
    const Eigenmodes modes = compute_eigenmodes(body, clamped_nodes(mesh, rig), wanted(count));
    expect_true_modes(body, modes);
    EXPECT_NEAR(modes.lambda_per_s2[1] / modes.lambda_per_s2[0], 1.0, 1e-8);
    // Second bendings: a pair again, with torsion before or after it.
    const bool torsion_first = modes.lambda_per_s2[3] / modes.lambda_per_s2[2] > 1.0 + 1e-6;
    if (count > 4) {
      const int first = torsion_first ? 3 : 2;
      EXPECT_NEAR(modes.lambda_per_s2[first + 1] / modes.lambda_per_s2[first], 1.0, 1e-8);
    }
  }
}

TEST(Eigenmodes, FindTheSecondCopyThatALanczosIterationPassesOver) {
  // NAFEMS FV52 on 4 x 4 elements: the ninth and tenth are a pair, of which one iteration sees but
  // one and answers with the eleventh.
  const HexMesh mesh = mesh_part(make_rig({Box{{0, 0, 0}, {10, 10, 1}}}), 2.5, ElementKind::Hex20);
  std::vector<int> held;
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    const Vector3d x = mesh.nodes.col(n);
    const Vector3d gap = x.cwiseMin(Vector3d(10, 10, 1) - x);
    if (x.z() < 1e-9 && gap.head<2>().minCoeff() < 1e-9) held.push_back(3 * n + 2);
  }
  const ElasticBody body(mesh, {test::elastic(200e9, 0.3, 8000)});
  const Eigenmodes modes =
      compute_eigenmodes(body, FreeDofs::from_held_dofs(mesh.num_nodes(), held), wanted(10));
  expect_true_modes(body, modes);
  EXPECT_EQ((modes.lambda_per_s2.array() == 0.0).count(), 3);
  EXPECT_NEAR(modes.lambda_per_s2[9] / modes.lambda_per_s2[8], 1.0, 1e-8);
}

TEST(RigidMotions, StrainNothingAndLeaveWhatIsHeldAtRest) {
  const HexMesh mesh = test::distorted_mesh(ElementKind::Hex8, 0.1);
  const ElasticBody body(mesh, {test::elastic(3.0, 0.3, 1.0)});
  const std::vector<std::vector<int>> held = {{}, {5}, {5, 20}, {5, 20, 30}};
  const std::vector<int> expected = {6, 3, 1, 0};
  for (std::size_t i = 0; i < held.size(); ++i) {
    const MatrixXd motions = rigid_motions(mesh, FreeDofs(mesh.num_nodes(), held[i]), {});
    ASSERT_EQ(motions.cols(), expected[i]);
    const double scale = body.stiffness({}).norm();
    EXPECT_LT((body.stiffness({}) * motions).norm(), 1e-13 * scale);  // round-off
    for (const int n : held[i]) EXPECT_LT(motions.middleRows(3 * n, 3).norm(), 1e-13);
    if (motions.cols() > 0) {
      EXPECT_GT(motions.colwise().norm().minCoeff(), 1.0);
    }
  }
}

TEST(Eigenmodes, ScaleOutWithModulusDensityAndSize) {
  const auto frequency = [](double E, double rho, double size) {
    const Rig rig = make_rig({Box{{0, 0, 0}, Vector3d(20, 3, 2) * size}},
                             {Box{{0, 0, 0}, Vector3d(0, 3, 2) * size}});
    const HexMesh mesh = mesh_part(rig, size, ElementKind::Hex8);
    const ElasticBody body(mesh, {test::elastic(E, 0.4, rho)});
    return compute_eigenmodes(body, clamped_nodes(mesh, rig), wanted(3)).natural_frequency_hz(2);
  };
  const double unit = frequency(1.0, 1.0, 1.0);
  EXPECT_NEAR(frequency(2e11, 8000.0, 1e-6) / (unit * std::sqrt(2e11 / 8000.0) * 1e6), 1.0, 1e-9);
  EXPECT_NEAR(frequency(1.0, 1000.0, 1e-3) / (unit * std::sqrt(1e-3) * 1e3), 1.0, 1e-9);
}

TEST(Eigenmodes, AHeavyWeightOnALightBeamSwingsOnItsSpring) {
  const Rig rig = test::beam_rig();
  const HexMesh mesh = mesh_part(rig, 2e-3, ElementKind::Hex20);
  ElasticBody body(mesh, {test::elastic(2e9, 0.45, 1e-3)});
  const MeshPoint tip = locate(mesh, {0.1, 0.005, 0.001});
  const double weight_kg = 0.02;
  body.add_point_mass(tip, weight_kg);
  const std::vector<int> held = clamped_nodes(mesh, rig);

  // Stiffness at the tip along z from a unit force.
  const FreeDofs free(mesh.num_nodes(), held);
  VectorXd force = VectorXd::Zero(mesh.num_dofs());
  for (std::size_t a = 0; a < tip.nodes.size(); ++a) {
    force[3 * tip.nodes[a] + 2] = tip.weights[static_cast<Eigen::Index>(a)];
  }
  const SparseMatrix K = free.restrict_matrix(body.stiffness({}));
  const auto solver = make_cholesky_solver();
  ASSERT_EQ(solver->analyze(K), SolveStatus::Ok);
  ASSERT_EQ(solver->factorize(K), SolveStatus::Ok);
  MatrixXd u;
  ASSERT_EQ(solver->solve(free.restrict_vector(force), u), SolveStatus::Ok);
  const double compliance = interpolate(tip, free.expand_vector(u)).z();

  const Eigenmodes modes = compute_eigenmodes(body, held, wanted(2));
  expect_true_modes(body, modes);
  // The beam itself weighs 2e-9 kg, 1e-7 of the weight.
  EXPECT_NEAR(modes.lambda_per_s2[0] * weight_kg * compliance, 1.0, 1e-6);
}

TEST(Eigenmodes, CompressionBeyondBucklingGivesANegativeEigenvalue) {
  const Rig rig = bar_rig(20);
  const HexMesh mesh = mesh_part(rig, 1.0, ElementKind::Hex20);
  const ElasticBody body(mesh, {test::elastic(3.0, 0.0, 1.0)});
  const auto first_lambda = [&](double strain) {
    VectorXd u = VectorXd::Zero(mesh.num_dofs());
    for (int n = 0; n < mesh.num_nodes(); ++n) u[3 * n] = strain * mesh.nodes(0, n);
    const Eigenmodes modes = compute_eigenmodes(body, clamped_nodes(mesh, rig), wanted(3), u);
    EXPECT_TRUE(modes.usable()) << modes.message;
    return modes.lambda_per_s2[0];
  };
  // Euler's strain of a cantilever: pi² I / (4 A L²) = pi² / (48 x 400) = 5.1e-4.
  EXPECT_GT(first_lambda(2e-4), first_lambda(0.0));
  EXPECT_GT(first_lambda(-4.9e-4), 0.0);
  EXPECT_LT(first_lambda(-5.4e-4), 0.0);
  EXPECT_LT(first_lambda(-5e-3), 10.0 * first_lambda(-5.4e-4));
}

TEST(Eigenmodes, AreTheSameEveryTime) {
  const Rig rig = test::beam_rig();
  const HexMesh mesh = mesh_part(rig, 4e-3, ElementKind::Hex8);
  const ElasticBody body(mesh, {test::elastic(2e9, 0.45, 1180)});
  const std::vector<int> held = clamped_nodes(mesh, rig);
  const Eigenmodes first = compute_eigenmodes(body, held, wanted(4));
  const Eigenmodes second = compute_eigenmodes(body, held, wanted(4));
  EXPECT_EQ(first.shapes, second.shapes);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(first.shapes.col(k).maxCoeff(), first.shapes.col(k).cwiseAbs().maxCoeff());
    for (const int n : held) EXPECT_EQ(first.shapes.block(3 * n, k, 3, 1).norm(), 0.0);
  }
}

TEST(Eigenmodes, ProgressCanStopThem) {
  const Rig rig = test::beam_rig();
  const HexMesh mesh = mesh_part(rig, 2e-3, ElementKind::Hex8);
  const ElasticBody body(mesh, {test::elastic(2e9, 0.45, 1180)});
  EigenmodeOptions options;
  int calls = 0;
  options.progress = [&](const Progress&) { return ++calls < 5; };
  EXPECT_THROW((void)compute_eigenmodes(body, clamped_nodes(mesh, rig), options), Cancelled);
  EXPECT_EQ(calls, 5);
}

TEST(Eigenmodes, RefuseWhatCannotBe) {
  const ElasticBody body(mesh_part(bar_rig(1), 1.0, ElementKind::Hex8),
                         {test::elastic(3.0, 0.3, 1.0)});
  const auto refusal = [&](const EigenmodeOptions& options) {
    return test::refusal_of([&] { (void)compute_eigenmodes(body, {0, 1}, options); });
  };
  EXPECT_TRUE(test::holds(refusal(wanted(0)), "count is 0"));
  EXPECT_TRUE(test::holds(refusal(wanted(19)), "must be <= 18"));
  EigenmodeOptions sloppy;
  sloppy.tolerance = 0.5;
  EXPECT_TRUE(test::holds(refusal(sloppy), "tolerance is 0.5"));
  sloppy.tolerance = 0.0;
  EXPECT_TRUE(test::holds(refusal(sloppy), "tolerance is 0"));
  EXPECT_NO_THROW(EigenmodeOptions{}.check());
}

}  // namespace
}  // namespace twang
