// SPDX-License-Identifier: GPL-3.0-or-later
// Static equilibrium by factor and by multigrid, and what a numerical modulus does to it.
#include "core/constants.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/static_solve.hpp"
#include "tests/support/rigs.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace twang {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

StaticOptions by(StiffnessSolverKind kind) {
  StaticOptions options;
  options.solver.kind = kind;
  options.solver.max_coarse_dofs = 400;  // several levels even of a small mesh
  return options;
}

/// A strip 50 x 5 x 2 mm of 500 cells with a weight on its end.
struct Strip {
  Rig rig =
      test::make_rig({test::box_mm({0, 0, 0}, {50, 5, 2})}, {test::box_mm({0, 0, 0}, {0, 5, 2})});
  HexMesh mesh;
  ElasticBody body;
  std::vector<int> held;
  MeshPoint tip;

  explicit Strip(ElementKind kind)
      : mesh(mesh_part(rig, 1e-3, kind)),
        body(mesh, {test::elastic(1e9, 0.4, 1180)}),
        held(clamped_nodes(mesh, rig)),
        tip(locate(mesh, {0.048, 0.003, 0.002})) {
    body.add_point_mass(tip, 2e-3);
  }
};

class EachVoxelElement : public ::testing::TestWithParam<ElementKind> {};
INSTANTIATE_TEST_SUITE_P(StaticByMultigrid,
                         EachVoxelElement,
                         ::testing::Values(ElementKind::Hex8, ElementKind::Hex8e),
                         [](const auto& kind) { return std::string(to_string(kind.param)); });

TEST_P(EachVoxelElement, SagEqualsThatByFactor) {
  const Strip strip(GetParam());
  StaticLoad weight;
  weight.force = strip.body.gravity_force({0.3, 0.0, -9.81});
  const StaticResult factor =
      solve_static(strip.body, strip.held, weight, by(StiffnessSolverKind::Factor));
  const StaticResult multigrid =
      solve_static(strip.body, strip.held, weight, by(StiffnessSolverKind::Multigrid));
  ASSERT_TRUE(factor.usable()) << factor.message;
  ASSERT_TRUE(multigrid.usable()) << multigrid.message;
  EXPECT_EQ(factor.linear_iterations, 0);
  EXPECT_GT(multigrid.linear_iterations, 0);
  EXPECT_NE(multigrid.solver.find("multigrid"), std::string::npos) << multigrid.solver;
  // Both are balanced to 1e-9 of the nodal forces; a strip 50 times as long as a cell is ~1e2
  // softer in bending.
  EXPECT_LT((factor.u - multigrid.u).norm(), 1e-7 * factor.u.norm());
}

TEST_P(EachVoxelElement, LargeDeflectionEqualsThatByFactor) {
  const Strip strip(GetParam());
  StaticLoad load;
  load.force = strip.body.gravity_force({0.0, 0.0, -9.81});
  load.pulled_point = strip.tip;
  load.pull = {0.0, 0.0005, -0.015};  // a third of its length
  const StaticResult factor =
      solve_static(strip.body, strip.held, load, by(StiffnessSolverKind::Factor));
  const StaticResult multigrid =
      solve_static(strip.body, strip.held, load, by(StiffnessSolverKind::Multigrid));
  ASSERT_TRUE(factor.usable()) << factor.message;
  ASSERT_TRUE(multigrid.usable()) << multigrid.message;
  EXPECT_LT((factor.u - multigrid.u).norm(), 1e-6 * factor.u.norm());
  EXPECT_NEAR(multigrid.pull_force_n / factor.pull_force_n, 1.0, 1e-6);
  EXPECT_NEAR(interpolate(strip.tip, multigrid.u).dot(load.pull.normalized()),
              load.pull.norm(),
              1e-12 * load.pull.norm());  // the constraint is kept exactly
}

TEST(StaticSolver, IsChosenByTheFactorsSizeAndSaysWhy) {
  const Strip strip(ElementKind::Hex8);
  StaticLoad weight;
  weight.force = strip.body.gravity_force({0.0, 0.0, -9.81});
  StaticOptions options;
  const StaticResult small = solve_static(strip.body, strip.held, weight, options);
  EXPECT_NE(small.solver.find("Cholesky"), std::string::npos) << small.solver;
  options.solver.max_factor_bytes = 1.0;
  const StaticResult large = solve_static(strip.body, strip.held, weight, options);
  ASSERT_TRUE(large.usable()) << large.message;
  EXPECT_NE(large.solver.find("a factor would take"), std::string::npos) << large.solver;
}

TEST(StaticSolver, LeavesAnUnstableEquilibriumForAMinimum) {
  // A column well beyond buckling: where it is straight K is indefinite, and the minimum is beside
  // it, on the side to which the load at its upper edge bends it.
  const Strip strip(ElementKind::Hex8);
  StaticLoad load;
  load.force = nodal_force(strip.mesh, strip.tip, {-10.0, 0.0, 0.0});
  const StaticResult result = solve_static(strip.body, strip.held, load);
  ASSERT_TRUE(result.usable()) << result.message;
  EXPECT_GT(interpolate(strip.tip, result.u).z(), 0.01);
  EigenmodeOptions options;
  options.count = 1;
  const Eigenmodes modes = compute_eigenmodes(strip.body, strip.held, options, result.u);
  ASSERT_TRUE(modes.usable()) << modes.message;
  EXPECT_GT(modes.lambda_per_s2[0], 0.0);
}

/// The L-rig at 1.5 mm.
struct LRig {
  HexMesh mesh;
  ElasticBody body;
  std::vector<int> held;

  LRig(ElementKind kind, double youngs_modulus)
      : mesh(mesh_part(test::l_rig(), 1.5e-3, kind)),
        body(mesh, {test::elastic(youngs_modulus, 0.45, 1205)}, ConstitutiveModel::Linear),
        held(clamped_nodes(mesh, test::l_rig())) {}

  [[nodiscard]] double first_lambda() const {
    EigenmodeOptions options;
    options.count = 1;
    const Eigenmodes modes = compute_eigenmodes(body, held, options);
    EXPECT_TRUE(modes.usable()) << modes.message;
    return modes.lambda_per_s2[0];
  }
  /// How far the arm's free end goes down under a force there [m].
  [[nodiscard]] double deflection(double force_n) const {
    const MeshPoint end = locate(mesh, {7.5e-3, 12e-3, 27e-3});
    StaticLoad load;
    load.force = nodal_force(mesh, end, {0.0, 0.0, -force_n});
    const StaticResult result = solve_static(body, held, load);
    EXPECT_TRUE(result.usable()) << result.message;
    return -interpolate(end, result.u).z();
  }
};

TEST(NumericalModulus, GivesTheFineMeshsStaticDeflectionWhereTheTrueOneIsTooStiff) {
  constexpr double kModulus = 1e9;
  constexpr double kForce = 0.5;
  const LRig fine(ElementKind::Hex20, kModulus);
  const LRig coarse(ElementKind::Hex8, kModulus);
  const double factor = fine.first_lambda() / coarse.first_lambda();
  const LRig numerical(ElementKind::Hex8, kModulus * factor);
  const double expected = fine.deflection(kForce);
  EXPECT_GT(expected, 1e-3);  // as thick as the leg, which it turns by two degrees
  // The load bends the leg as the first mode does, which the modulus is fitted to.
  EXPECT_NEAR(numerical.deflection(kForce) / expected, 1.0, 0.02);
  // 2.54 at this cell size, by the frequencies of CalculiX.
  EXPECT_NEAR(expected / coarse.deflection(kForce), 2.5, 0.1);
}

}  // namespace
}  // namespace twang
