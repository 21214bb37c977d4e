// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/stiffness_solver.hpp"

#include "fem/eigenmodes.hpp"
#include "tests/fem/distorted_mesh.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/finite_differences.hpp"
#include "tests/support/rigs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace twang {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

StiffnessSolverOptions multigrid(int max_coarse_dofs) {
  StiffnessSolverOptions options;
  options.kind = StiffnessSolverKind::Multigrid;
  options.max_coarse_dofs = max_coarse_dofs;
  options.tolerance = 1e-10;
  return options;
}

/// A body and what is held of it.
struct Case {
  ElasticBody body;
  FreeDofs free;
};
Case clamped(const Rig& rig,
             double dx_m,
             const std::vector<ElasticMaterial>& materials,
             ElementKind kind = ElementKind::Hex8) {
  HexMesh mesh = mesh_part(rig, dx_m, kind);
  FreeDofs free(mesh.num_nodes(), clamped_nodes(mesh, rig));
  return {ElasticBody(std::move(mesh), materials), std::move(free)};
}

/// 12 x 8 x 6, clamped at x = 0.
Rig block_rig() {
  return test::make_rig({Box{{0, 0, 0}, {12, 8, 6}}}, {Box{{0, 0, 0}, {0, 8, 6}}});
}

/// A leaf on a stem, of two materials where wanted; one cell thick at dx = 1.
Rig leaf_rig(bool two_materials = false) {
  Rig rig = test::make_rig({Box{{0, 0, 0}, {2, 2, 7}}, Box{{0, 0, 7}, {15, 9, 8}}},
                           {Box{{0, 0, 0}, {2, 2, 0}}});
  if (!two_materials) return rig;
  rig.materials.push_back(rig.materials.front());
  rig.materials.back().name = "leaf";
  rig.parts.back().material = "leaf";
  return rig;
}

SparseMatrix assembled(const Case& at, const StiffnessCombination& of, const VectorXd& u) {
  SparseMatrix A = of.stiffness * at.body.stiffness(u);
  A += of.damping * at.body.stiffness_damping(u);
  A += of.mass * at.body.mass();
  return at.free.restrict_matrix(A);
}

/// Solves for a random load and checks the residual against the assembled matrix; the iterations.
int iterations_of(const Case& at,
                  const StiffnessCombination& of,
                  int max_coarse_dofs,
                  const VectorXd& u = {}) {
  const auto solver = make_stiffness_solver(at.body, at.free, multigrid(max_coarse_dofs));
  EXPECT_EQ(solver->prepare(of, u), SolveStatus::Ok);
  const VectorXd b = test::random_vector(at.free.size(), 1.0, 2);
  MatrixXd x;
  const StiffnessSolution solution = solver->solve(b, x);
  if (solution.status != SolveStatus::Ok) {
    ADD_FAILURE() << solution.message;
    return std::numeric_limits<int>::max();
  }
  const SparseMatrix A = assembled(at, of, u);
  const double residual = (b - A * x).norm() / b.norm();
  // Beside the tolerance there is the round-off of A x, of which the recursion knows nothing.
  const double round_off = 1e-15 * A.diagonal().maxCoeff() * x.norm() / b.norm();
  EXPECT_LE(residual, 2e-10 + round_off);
  EXPECT_NEAR(residual, solution.relative_residual, 1e-11 + round_off);
  return solution.iterations;
}

TEST(Multigrid, ConvergesAtTheSamePaceOnFinerMeshes) {
  for (const double dx : {2.0, 1.0, 0.75}) {
    const Case at = clamped(block_rig(), dx, {test::elastic(1e9, 0.3, 1205)});
    EXPECT_LE(iterations_of(at, {}, 300), 11) << dx;  // 9 measured
  }
}

TEST(Multigrid, ConvergesOnThinLeavesOfTwoMaterialsAndNearIncompressibility) {
  // One cell thick, a hex8 bends ever worse on coarser grids: that is what the iterations are for.
  const ElasticMaterial soft = test::elastic(1e6, 0.45, 1205);
  const ElasticMaterial stiff = test::elastic(1e9, 0.3, 1205);
  EXPECT_LE(iterations_of(clamped(leaf_rig(), 1.0, {soft}), {}, 200), 50);
  EXPECT_LE(iterations_of(clamped(leaf_rig(true), 1.0, {soft, stiff}), {}, 200), 80);
  EXPECT_LE(iterations_of(clamped(leaf_rig(true), 1.0, {stiff, soft}), {}, 200), 60);
  EXPECT_LE(iterations_of(clamped(leaf_rig(), 1.0, {test::elastic(1e6, 0.499, 1205)}), {}, 200),
            90);
}

TEST(Multigrid, ConvergesByDegreeOnQuadraticElements) {
  const auto iterations = [](const Rig& rig, double dx, const std::vector<ElasticMaterial>& of) {
    return iterations_of(clamped(rig, dx, of, ElementKind::Hex20), {}, 300);
  };
  for (const double dx : {2.0, 1.0}) {
    EXPECT_LE(iterations(block_rig(), dx, {test::elastic(1e9, 0.3, 1205)}), 17) << dx;  // 14, 13
  }
  const ElasticMaterial soft = test::elastic(1e6, 0.45, 1205);
  const ElasticMaterial stiff = test::elastic(1e9, 0.3, 1205);
  // 52 and 45 measured, as many as hex8 needs on its own
  EXPECT_LE(iterations(leaf_rig(), 1.0, {soft}), 60);
  EXPECT_LE(iterations(leaf_rig(true), 1.0, {soft, stiff}), 55);
}

TEST(Multigrid, TakesMassDampingWeightsAndDisplacement) {
  Case at = clamped(leaf_rig(), 1.0, {test::elastic(1e6, 0.45, 1205)});
  ElasticMaterial damped = test::elastic(1e6, 0.45, 1205);
  damped.damping_stiffness_b_s = 2e-3;
  at.body = ElasticBody(at.body.mesh(), {damped});
  at.body.add_point_mass(locate(at.body.mesh(), {15, 9, 8}), 1e4);
  const double h = 1e-3;
  EXPECT_LE(iterations_of(at, {h * h / 4, h / 2, 1.0}, 200), 40);
  VectorXd stretched = VectorXd::Zero(at.body.mesh().num_dofs());
  for (int n = 0; n < at.body.mesh().num_nodes(); ++n) {
    stretched[3 * n] = 0.005 * at.body.mesh().nodes(0, n);
    stretched[3 * n + 2] = 0.005 * at.body.mesh().nodes(2, n);
  }
  EXPECT_LE(iterations_of(at, {1.0, 0.0, 0.0}, 200, stretched), 90);
}

TEST(Multigrid, CountsTheMemoryOfTheDeformedCoarseProblem) {
  const Case at = clamped(leaf_rig(), 1.0, {test::elastic(1e6, 0.45, 1205)});
  const auto solver = make_stiffness_solver(at.body, at.free, multigrid(200));
  ASSERT_EQ(solver->prepare({}), SolveStatus::Ok);
  const double undeformed = solver->memory_bytes();
  VectorXd turned = VectorXd::Zero(at.body.mesh().num_dofs());
  for (int n = 0; n < at.body.mesh().num_nodes(); ++n) {
    turned[3 * n] = 0.3 * at.body.mesh().nodes(2, n);
    turned[3 * n + 2] = -0.3 * at.body.mesh().nodes(0, n);
  }
  ASSERT_EQ(solver->prepare({1.0, 0.0, 1e9}, turned), SolveStatus::Ok);
  MatrixXd x;
  (void)solver->solve(test::random_vector(at.free.size(), 1.0, 3), x);
  EXPECT_EQ(solver->memory_bytes(), undeformed);  // heavy as it is, a few cycles do without
  ASSERT_EQ(solver->prepare({}, turned), SolveStatus::Ok);
  (void)solver->solve(test::random_vector(at.free.size(), 1.0, 3), x);
  EXPECT_GT(solver->memory_bytes(), undeformed + 8.0 * at.free.size());  // its functions alone
}

TEST(Multigrid, SolvesAsTheFactorDoes) {
  const Case at =
      clamped(leaf_rig(true), 1.0, {test::elastic(1, 0.3, 1), test::elastic(5, 0.4, 1)});
  StiffnessSolverOptions factor;
  factor.kind = StiffnessSolverKind::Factor;
  const auto direct = make_stiffness_solver(at.body, at.free, factor);
  const auto iterative = make_stiffness_solver(at.body, at.free, multigrid(200));
  EXPECT_EQ(direct->kind(), StiffnessSolverKind::Factor);
  EXPECT_EQ(iterative->kind(), StiffnessSolverKind::Multigrid);
  const MatrixXd B = test::random_vector(2 * at.free.size(), 1.0, 2).reshaped(at.free.size(), 2);
  MatrixXd X, Y;
  for (const StiffnessCombination& of :
       {StiffnessCombination{}, StiffnessCombination{2, 0, 1e-2}}) {
    ASSERT_EQ(direct->prepare(of), SolveStatus::Ok);
    ASSERT_EQ(iterative->prepare(of), SolveStatus::Ok);
    const StiffnessSolution exact = direct->solve(B, X);
    EXPECT_EQ(exact.status, SolveStatus::Ok);
    EXPECT_EQ(exact.iterations, 0);
    EXPECT_LT(exact.relative_residual, 1e-10);
    EXPECT_EQ(iterative->solve(B, Y).status, SolveStatus::Ok);
    // A residual of 1e-10 times the condition of a leaf, about 1e5, of which the loads excite part.
    EXPECT_LT((X - Y).norm(), 1e-6 * X.norm());
  }
}

TEST(Multigrid, ReportsAnIndefiniteMatrix) {
  const Case at = clamped(leaf_rig(), 1.0, {test::elastic(1.0, 0.3, 1.0)});
  EigenmodeOptions one;
  one.count = 1;
  const double first = compute_eigenmodes(at.body, at.free, one).lambda_per_s2[0];
  const auto solver = make_stiffness_solver(at.body, at.free, multigrid(200));
  // Just above the first eigenvalue the stiffer coarse grids still are definite: conjugate
  // gradients find out. Far above, the factor of the coarsest does.
  const VectorXd b = test::random_vector(at.free.size(), 1.0, 2);
  MatrixXd x;
  ASSERT_EQ(solver->prepare({1.0, 0.0, -1.02 * first}), SolveStatus::Ok);
  const StiffnessSolution solution = solver->solve(b, x);
  EXPECT_EQ(solution.status, SolveStatus::NotPositiveDefinite);
  EXPECT_TRUE(test::holds(solution.message, "not positive definite"));
  EXPECT_EQ(solver->prepare({1.0, 0.0, -1e3 * first}), SolveStatus::NotPositiveDefinite);
  EXPECT_EQ(solver->solve(b, x).status, SolveStatus::NotFactorized);
  ASSERT_EQ(solver->prepare({1.0, 0.0, -0.9 * first}), SolveStatus::Ok);
  EXPECT_EQ(solver->solve(b, x).status, SolveStatus::Ok);
}

TEST(Multigrid, SaysWhenItDoesNotConverge) {
  const Case at = clamped(leaf_rig(), 1.0, {test::elastic(1.0, 0.3, 1.0)});
  StiffnessSolverOptions hurried = multigrid(200);
  hurried.max_iterations = 2;
  const auto solver = make_stiffness_solver(at.body, at.free, hurried);
  MatrixXd x;
  const VectorXd b = test::random_vector(at.free.size(), 1.0, 2);
  EXPECT_EQ(solver->solve(b, x).status, SolveStatus::NotFactorized);
  ASSERT_EQ(solver->prepare({}), SolveStatus::Ok);
  const StiffnessSolution solution = solver->solve(b, x);
  EXPECT_EQ(solution.status, SolveStatus::NotConverged);
  EXPECT_EQ(solution.iterations, 2);
  EXPECT_GT(solution.relative_residual, 1e-10);
  EXPECT_TRUE(test::holds(solution.message, "after 2 iterations"));
}

TEST(StiffnessSolver, ChoosesByTheFactorsSizeAndSaysWhy) {
  const Case small = clamped(leaf_rig(), 1.0, {test::elastic(1.0, 0.3, 1.0)});
  EXPECT_EQ(make_stiffness_solver(small.body, small.free)->kind(), StiffnessSolverKind::Factor);
  StiffnessSolverOptions tight;
  tight.max_factor_bytes = 1e6;
  const auto chosen = make_stiffness_solver(small.body, small.free, tight);
  EXPECT_EQ(chosen->kind(), StiffnessSolverKind::Multigrid);
  EXPECT_TRUE(test::holds(chosen->description(), "a factor would take about"));
  EXPECT_GT(chosen->memory_bytes(), 1e4);
  HexMesh curved = mesh_part(leaf_rig(), 1.0, ElementKind::Hex20);
  curved.nodes(0, curved.elements(13, 0)) += 0.01;
  const ElasticBody body(curved, {test::elastic(1.0, 0.3, 1.0)});
  const FreeDofs free(curved.num_nodes(), {0});
  const auto forced = make_stiffness_solver(body, free, tight);
  EXPECT_EQ(forced->kind(), StiffnessSolverKind::Factor);
  EXPECT_TRUE(test::holds(forced->description(), "its edges are curved"));
  EXPECT_TRUE(test::holds(
      test::refusal_of([&] { (void)make_stiffness_solver(body, free, multigrid(200)); }),
      "does not fit the mesh"));
  // Measured: 1 GB at 178,000 and 11 GB at 1,240,000 unknowns.
  EXPECT_NEAR(estimate_factor_bytes(178'000), 1e9, 1e8);
  EXPECT_NEAR(estimate_factor_bytes(1'240'000), 11e9, 1e9);
}

TEST(StiffnessSolverOptions, RefuseWhatCannotBe) {
  const auto refusal = [](auto member, auto value) {
    StiffnessSolverOptions options;
    options.*member = value;
    return test::refusal_of([&] { options.check(); });
  };
  EXPECT_TRUE(test::holds(refusal(&StiffnessSolverOptions::tolerance, 0.0), "tolerance is 0"));
  EXPECT_TRUE(test::holds(refusal(&StiffnessSolverOptions::tolerance, 1.0), "tolerance is 1"));
  EXPECT_TRUE(test::holds(refusal(&StiffnessSolverOptions::max_iterations, 0), "max_iterations"));
  EXPECT_TRUE(
      test::holds(refusal(&StiffnessSolverOptions::max_factor_bytes, -1.0), "max_factor_bytes"));
  EXPECT_TRUE(test::holds(refusal(&StiffnessSolverOptions::max_coarse_dofs, 0), "max_coarse_dofs"));
  EXPECT_NO_THROW(StiffnessSolverOptions{}.check());
}

}  // namespace
}  // namespace twang
