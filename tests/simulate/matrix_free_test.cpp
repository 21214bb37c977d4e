// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "fem/multigrid_preconditioner.hpp"
#include "fem/static_solve.hpp"
#include "simulate/detail/state_stream.hpp"
#include "simulate/integrators.hpp"
#include "tests/simulate/moving_block.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

using test::block;
using test::moving;
using test::nodes_at;
using test::rubber;

/// Coarse enough at the bottom that there are two levels and more.
StiffnessSolverOptions multigrid() {
  StiffnessSolverOptions options;
  options.kind = StiffnessSolverKind::Multigrid;
  options.max_coarse_dofs = 300;
  return options;
}

StaticOptions by_multigrid() {
  StaticOptions options;
  options.solver = multigrid();
  return options;
}

IntegratorOptions stepping(const StiffnessSolverOptions& solver) {
  IntegratorOptions options;
  options.step_s = 2e-4;
  options.tolerance = 1e-10;
  options.solver = solver;
  return options;
}

TEST(MatrixFree, StepsAsTheFactorDoesAtLargeDeflection) {
  const ElasticBody body = block(rubber(1e-4), ConstitutiveModel::NeoHookean, {12, 4, 4});
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  StaticLoad pull;
  pull.pulled_point = locate(body.mesh(), {0.03, 0.005, 0.005});
  pull.pull = {0.0, 0.0, 0.015};  // half the length
  const StaticResult start = solve_static(body, held, pull);
  ASSERT_TRUE(start.usable()) << start.message;
  const auto end_of = [&](const StiffnessSolverOptions& solver) {
    BodyState state{start.u, Eigen::VectorXd::Zero(start.u.size()), 0.0};
    Integrator integrator(body, held, stepping(solver));
    const RunSummary summary = run(integrator, state, 2e-4, 6e-3, {});
    EXPECT_TRUE(summary.usable()) << summary.message;
    EXPECT_LT(summary.linear_iterations, 40 * summary.steps);
    if (solver.kind == StiffnessSolverKind::Multigrid) {
      EXPECT_EQ(summary.factorizations, 1);
      EXPECT_NE(integrator.solver().find("multigrid"), std::string::npos);
    }
    return state.u;
  };
  const Eigen::VectorXd by_factor = end_of({});
  // Both residuals are 1e-10 of the forces in each of 30 steps.
  EXPECT_LT((end_of(multigrid()) - by_factor).norm(), 1e-7 * by_factor.norm());
  EXPECT_GT((by_factor - start.u).norm(), 0.3 * start.u.norm());
}

TEST(MatrixFree, FindsTheEquilibriaThatTheFactorFinds) {
  const ElasticBody body = block(rubber(), ConstitutiveModel::NeoHookean, {12, 4, 4});
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  for (const bool pulled : {true, false}) {
    StaticLoad load;
    load.force = body.gravity_force({0.0, 3.0, -30.0});
    if (pulled) {
      load.pulled_point = locate(body.mesh(), {0.03, 0.005, 0.005});
      load.pull = {0.0, 0.001, 0.012};
    }
    const StaticResult by_factor = solve_static(body, held, load);
    const StaticResult found = solve_static(body, held, load, by_multigrid());
    ASSERT_TRUE(by_factor.usable() && found.usable()) << by_factor.message << found.message;
    // residuals of 1e-9 of the forces; the softest mode is some thousand times softer than these
    EXPECT_LT((found.u - by_factor.u).norm(), 1e-6 * by_factor.u.norm());
    EXPECT_NEAR(found.pull_force_n, by_factor.pull_force_n, 1e-6 * by_factor.pull_force_n + 1e-12);
    if (pulled) {
      const Eigen::Vector3d at = interpolate(*load.pulled_point, found.u);
      EXPECT_NEAR(at.dot(load.pull.normalized()), load.pull.norm(), 1e-12);
    }
  }
}

TEST(MatrixFree, EquilibriumThatIsNotThereEndsInASentence) {
  const ElasticBody body = block(rubber());
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  StaticLoad load;
  load.force = body.gravity_force({-1e9, 0.0, 0.0});
  const StaticResult result = solve_static(body, held, load, by_multigrid());
  EXPECT_FALSE(result.usable());
  EXPECT_TRUE(result.u.allFinite());
  EXPECT_NE(result.message.find("no equilibrium found beyond"), std::string::npos);
}

TEST(MatrixFree, RestoredGoesOnBitByBit) {
  const ElasticBody body = block(rubber(1e-4));
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  Integrator first(body, held, stepping(multigrid()));
  BodyState a = moving(body.mesh(), 2.0);
  for (int i = 0; i < 12; ++i) ASSERT_EQ(first.step(a).termination, Termination::Converged);
  detail::StateWriter writer;
  first.save(writer);
  BodyState b = a;
  Integrator second(body, held, stepping(multigrid()));
  detail::StateReader reader(writer.bytes(), "memory");
  second.restore(reader);
  for (int i = 0; i < 12; ++i) {
    ASSERT_EQ(first.step(a).termination, Termination::Converged);
    ASSERT_EQ(second.step(b).termination, Termination::Converged);
  }
  EXPECT_EQ(a.u, b.u);
}

TEST(MultigridPreconditioner, IsNearlyTheInverse) {
  const ElasticBody body = block(rubber(), ConstitutiveModel::Linear, {12, 4, 4});
  const FreeDofs free(body.mesh().num_nodes(), nodes_at(body.mesh(), 0, 0.0));
  MultigridPreconditioner preconditioner(body, free, 300);
  const StiffnessCombination of = {1.0, 0.0, 1e6};
  ASSERT_EQ(preconditioner.prepare(of), SolveStatus::Ok);
  SparseMatrix A = body.stiffness({});
  body.add_scaled_mass(of.mass, A);
  const SparseMatrix free_matrix = free.restrict_matrix(A);
  // what the estimate promises of its norm
  EXPECT_NEAR(
      preconditioner.estimate_diagonal(of).norm() / free_matrix.diagonal().norm(), 1.0, 0.1);
  const Eigen::VectorXd x = free.restrict_vector(test::smooth_field(body.mesh(), 1.0));
  EXPECT_LT((preconditioner.apply(free_matrix * x) - x).norm(), 0.2 * x.norm());

  HexMesh bent = body.mesh();
  bent.nodes.col(0) += Eigen::Vector3d(1e-4, 0.0, 0.0);
  const ElasticBody other(bent, {rubber()});
  EXPECT_FALSE(prefers_multigrid(other, free));
  EXPECT_THROW(MultigridPreconditioner(other, free), InputError);
}

}  // namespace
}  // namespace twang
