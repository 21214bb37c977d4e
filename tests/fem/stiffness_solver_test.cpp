// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/stiffness_solver.hpp"

#include "tests/fem/distorted_mesh.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/finite_differences.hpp"
#include "tests/support/rigs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

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
  EXPECT_EQ(solution.status, SolveStatus::Ok) << solution.message;
  SparseMatrix A = of.stiffness * at.body.stiffness(u);
  A += of.damping * at.body.stiffness_damping(u);
  A += of.mass * at.body.mass();
  const double residual = (b - at.free.restrict_matrix(A) * x).norm() / b.norm();
  EXPECT_LE(residual, 2e-10);  // the tolerance, and round-off between recursion and truth
  EXPECT_NEAR(residual, solution.relative_residual, 1e-10);
  std::printf("%s: %d\n", solver->description().c_str(), solution.iterations);
  return solution.iterations;
}

TEST(Multigrid, ConvergesAtTheSamePaceOnFinerMeshes) {
  const std::vector<ElasticMaterial> material = {test::elastic(1e9, 0.3, 1205)};
  for (const double dx : {1.5e-3, 0.75e-3}) {
    const Case at = clamped(test::l_rig(), dx, material);
    EXPECT_LE(iterations_of(at, {}, 2000), 16) << dx;
  }
}
TEST(Multigrid, Scratch) {
  for (double nu : {0.0,0.3,0.45,0.499}) {
    const Case at = clamped(test::l_rig(), 0.75e-3, {test::elastic(1e9, nu, 1205)});
    std::printf("nu %g ", nu);
    iterations_of(at, {}, 3000);
  }
  for (double dx : {2e-3, 1e-3, 0.5e-3}) {
    const Case at = clamped(test::beam_rig(), dx, {test::elastic(1e9, 0.45, 1205)});
    std::printf("beam %g ", dx);
    iterations_of(at, {}, 500);
  }
}

}  // namespace
}  // namespace twang
