// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/lobpcg.hpp"
#include "fem/eigenmodes.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/finite_differences.hpp"
#include "tests/support/rigs.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::elastic;

/// A leaf one cell thick on a stem of another material.
Rig leaf_rig() {
  Rig rig = test::make_rig({Box{{0, 0, 0}, {2, 2, 5}}, Box{{0, 0, 5}, {11, 6, 6}}},
                           {Box{{0, 0, 0}, {2, 2, 0}}});
  rig.materials.push_back(rig.materials.front());
  rig.materials.back().name = "leaf";
  rig.parts.back().material = "leaf";
  return rig;
}

EigenmodeOptions with(StiffnessSolverKind kind, int count) {
  EigenmodeOptions options;
  options.count = count;
  options.solver.kind = kind;
  options.solver.max_coarse_dofs = 150;  // three or four levels
  return options;
}

/// The same eigenvalues by multigrid as by factor, to the relative accuracy asked for.
Eigenmodes expect_as_by_factor(const ElasticBody& body,
                               const FreeDofs& free,
                               int count,
                               const VectorXd& u = {}) {
  const Eigenmodes factor =
      compute_eigenmodes(body, free, with(StiffnessSolverKind::Factor, count), u);
  const Eigenmodes modes =
      compute_eigenmodes(body, free, with(StiffnessSolverKind::Multigrid, count), u);
  EXPECT_TRUE(modes.usable()) << modes.message;
  EXPECT_EQ(modes.solver, StiffnessSolverKind::Multigrid);
  EXPECT_EQ(factor.solver, StiffnessSolverKind::Factor);
  if (!modes.usable()) return modes;
  for (int k = 0; k < count; ++k) {
    const double expected = factor.lambda_per_s2[k];
    EXPECT_NEAR(modes.lambda_per_s2[k], expected, 1e-8 * std::abs(expected)) << k;
  }
  const MatrixXd gram = modes.shapes.transpose() * (body.mass() * modes.shapes);
  const double error = (gram - MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff();
  EXPECT_LT(error, 1e-11);  // round-off of a dozen recombinations
  EXPECT_NEAR(error, modes.max_orthonormality_error, 1e-12);
  // The shapes err by the square root of what the eigenvalues do, 1e-6, in the energy; the
  // residual weighs what is rough in them by the largest eigenvalue over the mode's.
  EXPECT_LT(modes.max_residual, 0.05);
  EXPECT_GT(modes.max_residual, 0.0);
  for (const int dof : free.held_dofs()) EXPECT_EQ(modes.shapes.row(dof).norm(), 0.0);
  return modes;
}

TEST(EigenmodesByMultigrid, EqualThoseByFactorOnThinLeavesOfTwoMaterials) {
  HexMesh mesh = mesh_part(leaf_rig(), 1.0, ElementKind::Hex8);
  const std::vector<int> held = clamped_nodes(mesh, leaf_rig());
  const FreeDofs free(mesh.num_nodes(), held);
  const ElasticMaterial soft = elastic(1e6, 0.45, 1200);
  const ElasticMaterial stiff = elastic(1e9, 0.2, 2700);
  expect_as_by_factor(ElasticBody(mesh, {soft, stiff}), free, 6);
  expect_as_by_factor(ElasticBody(mesh, {stiff, soft}), free, 6);
  for (int axis = 0; axis < 3; ++axis) mesh.nodes.row(axis) *= 1.0 + 0.4 * axis;
  expect_as_by_factor(ElasticBody(mesh, {stiff, stiff}), free, 6);
  mesh.stiffness_fill = test::random_vector(mesh.num_elements(), 0.4, 7).array() + 0.6;
  mesh.mass_fill = test::random_vector(mesh.num_elements(), 0.4, 8).array() + 0.9;
  expect_as_by_factor(ElasticBody(mesh, {soft, stiff}), free, 4);
}

TEST(EigenmodesByMultigrid, EqualThoseByFactorNearIncompressibility) {
  const HexMesh mesh = mesh_part(leaf_rig(), 1.0, ElementKind::Hex8);
  const FreeDofs free(mesh.num_nodes(), clamped_nodes(mesh, leaf_rig()));
  for (const double nu : {0.45, 0.499}) {
    expect_as_by_factor(ElasticBody(mesh, {elastic(1, nu, 1), elastic(1, nu, 1)}), free, 5);
  }
}

TEST(EigenmodesByMultigrid, FreeBodiesHaveSixZeroModesKeptOutExactly) {
  const HexMesh mesh = mesh_part(leaf_rig(), 1.0, ElementKind::Hex8);
  const ElasticBody body(mesh, {elastic(1, 0.3, 1), elastic(1, 0.3, 1)});
  const Eigenmodes modes = expect_as_by_factor(body, FreeDofs(mesh.num_nodes(), {}), 10);
  EXPECT_EQ((modes.lambda_per_s2.array() == 0.0).count(), 6);
  const VectorXd strain = body.stiffness({}) * modes.shapes.leftCols<6>().rowwise().sum();
  EXPECT_LT(strain.norm(), 1e-12 * body.stiffness({}).norm());  // round-off
  // One node held leaves three rotations, and only some of them may be wanted.
  expect_as_by_factor(body, FreeDofs(mesh.num_nodes(), {0}), 6);
  const Eigenmodes few =
      compute_eigenmodes(body, std::vector<int>{}, with(StiffnessSolverKind::Multigrid, 4));
  EXPECT_TRUE(few.usable()) << few.message;
  EXPECT_EQ(few.lambda_per_s2.norm(), 0.0);
}

TEST(EigenmodesByMultigrid, EqualThoseByFactorOfEnhancedElements) {
  HexMesh mesh = mesh_part(leaf_rig(), 1.0, ElementKind::Hex8e);
  const FreeDofs free(mesh.num_nodes(), clamped_nodes(mesh, leaf_rig()));
  expect_as_by_factor(ElasticBody(mesh, {elastic(1, 0.45, 1), elastic(20, 0.2, 1)}), free, 5);
  for (int axis = 0; axis < 3; ++axis) mesh.nodes.row(axis) *= 1.0 + 0.4 * axis;
  expect_as_by_factor(ElasticBody(mesh, {elastic(1, 0.499, 1), elastic(1, 0.499, 1)}), free, 5);
}

TEST(EigenmodesByMultigrid, EqualThoseByFactorOfQuadraticElements) {
  HexMesh mesh = mesh_part(leaf_rig(), 1.5, ElementKind::Hex20);
  const FreeDofs free(mesh.num_nodes(), clamped_nodes(mesh, leaf_rig()));
  expect_as_by_factor(ElasticBody(mesh, {elastic(1, 0.45, 1), elastic(20, 0.2, 1)}), free, 5);
  for (int axis = 0; axis < 3; ++axis) mesh.nodes.row(axis) *= 1.0 + 0.4 * axis;
  expect_as_by_factor(ElasticBody(mesh, {elastic(1, 0.49, 1), elastic(1, 0.49, 1)}), free, 5);
  mesh.stiffness_fill = test::random_vector(mesh.num_elements(), 0.4, 7).array() + 0.6;
  mesh.mass_fill = test::random_vector(mesh.num_elements(), 0.4, 8).array() + 0.9;
  ElasticBody body(mesh, {elastic(1, 0.3, 1), elastic(1, 0.3, 1)});
  body.add_point_mass(locate(mesh, mesh.nodes.rowwise().maxCoeff()), 30.0);
  expect_as_by_factor(body, free, 4);
  expect_as_by_factor(body, FreeDofs(mesh.num_nodes(), {}), 8);
  VectorXd u = VectorXd::Zero(mesh.num_dofs());
  for (int n = 0; n < mesh.num_nodes(); ++n) u[3 * n] = 0.004 * mesh.nodes(2, n) * mesh.nodes(2, n);
  const double bent = expect_as_by_factor(body, free, 4, u).lambda_per_s2[0];
  EXPECT_GT(std::abs(bent / expect_as_by_factor(body, free, 4).lambda_per_s2[0] - 1.0), 1e-3);
}

TEST(EigenmodesByMultigrid, AreTheFasterWayOnManyQuadraticElements) {
  const Rig rig = test::make_rig({Box{{0, 0, 0}, {30, 3, 2}}}, {Box{{0, 0, 0}, {0, 3, 2}}});
  const HexMesh mesh = mesh_part(rig, 1.0, ElementKind::Hex20);
  const ElasticBody body(mesh, {elastic(1, 0.3, 1)});
  EigenmodeOptions options;
  EXPECT_EQ(options.solver.max_quadratic_factor_dofs, 20'000);
  options.count = 3;
  options.solver.max_quadratic_factor_dofs = 1'000;
  const std::vector<int> held = clamped_nodes(mesh, rig);
  const Eigenmodes modes = compute_eigenmodes(body, held, options);
  EXPECT_EQ(modes.solver, StiffnessSolverKind::Multigrid);
  EXPECT_TRUE(test::holds(modes.message, "sooner than a factor")) << modes.message;
  options.solver.kind = StiffnessSolverKind::Factor;
  const Eigenmodes factor = compute_eigenmodes(body, held, options);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(modes.lambda_per_s2[k] / factor.lambda_per_s2[k], 1.0, 1e-9) << k;
  }
}

TEST(EigenmodesByMultigrid, LeaveItToTheFactorWhereTheyDoNotConverge) {
  // Next to incompressible, in elements whose sides differ fivefold.
  const Rig rig = test::make_rig({Box{{0, 0, 0}, {30, 3, 2}}}, {Box{{0, 0, 0}, {0, 3, 2}}});
  HexMesh mesh = mesh_part(rig, 1.0, ElementKind::Hex20);
  mesh.nodes.row(0) *= 5.0;
  const ElasticBody body(mesh, {elastic(1, 0.49999, 1)});
  EigenmodeOptions options;
  options.count = 1;
  options.solver.max_quadratic_factor_dofs = 1'000;
  options.solver.max_coarse_dofs = 300;
  const Eigenmodes modes = compute_eigenmodes(body, clamped_nodes(mesh, rig), options);
  EXPECT_TRUE(modes.usable()) << modes.message;
  EXPECT_EQ(modes.solver, StiffnessSolverKind::Factor);
  EXPECT_TRUE(test::holds(modes.message, "by Cholesky factor, as by multigrid after"));
}

TEST(EigenmodesByMultigrid, FindBothBendingsOfASquareBar) {
  const Rig rig = test::make_rig({Box{{0, 0, 0}, {14, 3, 3}}}, {Box{{0, 0, 0}, {0, 3, 3}}});
  const HexMesh mesh = mesh_part(rig, 1.0, ElementKind::Hex8);
  const ElasticBody body(mesh, {elastic(1, 0.3, 1)});
  for (const int count : {1, 5}) {
    const Eigenmodes modes =
        expect_as_by_factor(body, FreeDofs(mesh.num_nodes(), clamped_nodes(mesh, rig)), count);
    if (count == 1) continue;
    EXPECT_NEAR(modes.lambda_per_s2[1] / modes.lambda_per_s2[0], 1.0, 1e-8);
  }
}

TEST(EigenmodesByMultigrid, TakeWeightsAndPrestress) {
  const HexMesh mesh = mesh_part(leaf_rig(), 1.0, ElementKind::Hex8);
  const FreeDofs free(mesh.num_nodes(), clamped_nodes(mesh, leaf_rig()));
  ElasticBody body(mesh, {elastic(1, 0.3, 1), elastic(1, 0.3, 1)});
  body.add_point_mass(locate(mesh, {11, 6, 6}), 30.0);
  expect_as_by_factor(body, free, 4);
  VectorXd u = VectorXd::Zero(mesh.num_dofs());
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    u[3 * n] = 0.01 * mesh.nodes(2, n) * mesh.nodes(2, n);
    u[3 * n + 2] = 0.02 * mesh.nodes(0, n) * mesh.nodes(2, n) / 5.0;
  }
  const double bent = expect_as_by_factor(body, free, 4, u).lambda_per_s2[0];
  EXPECT_GT(std::abs(bent / expect_as_by_factor(body, free, 4).lambda_per_s2[0] - 1.0), 1e-3);
}

TEST(EigenmodesByMultigrid, AreChosenWhereAFactorWouldBeTooLarge) {
  const HexMesh mesh = mesh_part(leaf_rig(), 1.0, ElementKind::Hex8);
  const std::vector<int> held = clamped_nodes(mesh, leaf_rig());
  const ElasticBody body(mesh, {elastic(1, 0.3, 1), elastic(1, 0.3, 1)});
  EigenmodeOptions options = with(StiffnessSolverKind::Automatic, 3);
  const Eigenmodes small = compute_eigenmodes(body, held, options);
  EXPECT_EQ(small.solver, StiffnessSolverKind::Factor);
  EXPECT_TRUE(test::holds(small.message, "Cholesky"));
  options.solver.max_factor_bytes = 1e5;
  const Eigenmodes large = compute_eigenmodes(body, held, options);
  EXPECT_EQ(large.solver, StiffnessSolverKind::Multigrid);
  EXPECT_TRUE(test::holds(large.message, "multigrid: a factor would take about"));
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(large.shapes.col(k).maxCoeff(), large.shapes.col(k).cwiseAbs().maxCoeff());
  }
  HexMesh quadratic = mesh_part(leaf_rig(), 1.0, ElementKind::Hex20);
  quadratic.nodes(0, quadratic.elements(13, 0)) += 0.01;
  const ElasticBody other(quadratic, {elastic(1, 0.3, 1), elastic(1, 0.3, 1)});
  const Eigenmodes fallen_back =
      compute_eigenmodes(other, clamped_nodes(quadratic, leaf_rig()), options);
  EXPECT_EQ(fallen_back.solver, StiffnessSolverKind::Factor);
  EXPECT_TRUE(test::holds(fallen_back.message, "there is no multigrid: its edges are curved"));
  options.solver.kind = StiffnessSolverKind::Multigrid;
  EXPECT_TRUE(test::holds(
      test::refusal_of([&] { (void)compute_eigenmodes(other, std::vector<int>{0}, options); }),
      "does not fit the mesh"));
}

/// -u'' on n inner points with ends held: eigenvalues 2 - 2 cos(k pi / (n + 1)).
PreconditionedProblem chain() {
  PreconditionedProblem problem;
  problem.apply_stiffness = [](const VectorXd& x) {
    VectorXd y = 2.0 * x;
    y.head(x.size() - 1) -= x.tail(x.size() - 1);
    y.tail(x.size() - 1) -= x.head(x.size() - 1);
    return y;
  };
  problem.apply_mass = [](const VectorXd& x) { return VectorXd(2.0 * x); };
  problem.precondition = [](const VectorXd& x) { return x; };
  return problem;
}

TEST(Lobpcg, FindsTheSmallestEigenvaluesOfAChainWithoutAPreconditioner) {
  const int n = 40;
  LobpcgOptions options;
  options.count = 4;
  // r . r / theta is what the estimate becomes without one, 1 / theta larger than the error at
  // most.
  options.tolerance = 1e-12;
  const LobpcgResult result = find_smallest_preconditioned(
      chain(), test::random_vector(6 * n, 1.0, 3).reshaped(n, 6), options);
  ASSERT_EQ(result.termination, Termination::Converged) << result.message;
  EXPECT_GT(result.iterations, 3);
  for (int k = 0; k < 4; ++k) {
    const double exact = 0.5 * (2.0 - 2.0 * std::cos((k + 1) * M_PI / (n + 1)));
    EXPECT_NEAR(result.lambda[k] / exact, 1.0, 1e-9) << k;
  }
  const MatrixXd gram = 2.0 * result.vectors.transpose() * result.vectors;
  EXPECT_LT((gram - MatrixXd::Identity(4, 4)).norm(), 1e-12);  // round-off
}

TEST(Lobpcg, LeavesOutWhatIsKnown) {
  const int n = 30;
  PreconditionedProblem problem = chain();
  problem.known.resize(n, 1);
  for (int i = 0; i < n; ++i) problem.known(i, 0) = std::sin((i + 1) * M_PI / (n + 1));
  problem.known /= std::sqrt(2.0) * problem.known.norm();
  LobpcgOptions options;
  options.count = 1;
  const LobpcgResult result = find_smallest_preconditioned(
      problem, test::random_vector(3 * n, 1.0, 3).reshaped(n, 3), options);
  ASSERT_EQ(result.termination, Termination::Converged) << result.message;
  EXPECT_NEAR(result.lambda[0], 1.0 - std::cos(2 * M_PI / (n + 1)), 1e-9);
}

TEST(Lobpcg, SaysWhenItStopsShortOrCannotStart) {
  LobpcgOptions options;
  options.count = 2;
  options.max_iterations = 1;
  const LobpcgResult stopped = find_smallest_preconditioned(
      chain(), test::random_vector(120, 1.0, 3).reshaped(40, 3), options);
  EXPECT_EQ(stopped.termination, Termination::IterationLimit);
  EXPECT_TRUE(test::holds(stopped.message, "after 1 block iterations"));
  const LobpcgResult dependent =
      find_smallest_preconditioned(chain(), MatrixXd::Ones(40, 3), options);
  EXPECT_EQ(dependent.termination, Termination::NumericalFailure);
}

}  // namespace
}  // namespace twang
