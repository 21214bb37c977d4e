// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/static_solve.hpp"

#include "core/error.hpp"
#include "tests/simulate/box_body.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using test::box_mesh;
using test::mean_over;
using test::nodes_at;

ElasticMaterial material(double youngs_modulus, double poissons_ratio, double density) {
  ElasticMaterial result;
  result.youngs_modulus_pa = youngs_modulus;
  result.poissons_ratio = poissons_ratio;
  result.density_kg_m3 = density;
  return result;
}

/// 60 x 8 x 4 mm of a printed polymer, held at x = 0.
struct Cantilever {
  ElasticBody body{box_mesh(ElementKind::Hex8, {15, 2, 2}, {0.06, 0.008, 0.004}),
                   {material(1e9, 0.4, 1200.0)}};
  std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  MeshPoint tip = locate(body.mesh(), {0.058, 0.003, 0.004});
};

TEST(StaticSolve, BarUnderItsOwnWeightSettlesByRhoGLSquaredOver2E) {
  const double E = 2e6;
  const double rho = 1100.0;
  const double g = 9.81;
  const double L = 0.4;
  const ElasticBody body(box_mesh(ElementKind::Hex8, {1, 1, 8}, {0.02, 0.03, L}),
                         {material(E, 0.0, rho)},
                         ConstitutiveModel::Linear);
  StaticLoad load;
  load.force = body.gravity_force({0.0, 0.0, -g});
  const StaticResult result = solve_static(body, nodes_at(body.mesh(), 2, 0.0), load);
  ASSERT_TRUE(result.usable()) << result.message;
  const double sag = mean_over(nodes_at(body.mesh(), 2, L), result.u).z();
  // Linear elements are nodally exact in one dimension; what is left is round-off.
  EXPECT_NEAR(sag, -rho * g * L * L / (2.0 * E), 1e-9 * std::abs(sag));
}

TEST(StaticSolve, CantileverUnderItsOwnWeightBendsAsTimoshenkoSays) {
  const double E = 1e9;
  const double rho = 1200.0;
  const double g = 9.81;
  const Eigen::Vector3d size(0.1, 0.012, 0.01);
  const ElasticBody body(box_mesh(ElementKind::Hex20, {10, 1, 1}, size), {material(E, 0.0, rho)});
  StaticLoad load;
  load.force = body.gravity_force({0.0, 0.0, -g});
  const StaticResult result = solve_static(body, nodes_at(body.mesh(), 0, 0.0), load);
  ASSERT_TRUE(result.usable()) << result.message;
  const double area = size.y() * size.z();
  const double inertia = size.y() * std::pow(size.z(), 3) / 12.0;
  const double weight = rho * g * area;
  const double L = size.x();
  const double expected = weight * std::pow(L, 4) / (8.0 * E * inertia) +
                          weight * L * L / (2.0 * (5.0 / 6.0) * (E / 2.0) * area);
  const double sag = -mean_over(nodes_at(body.mesh(), 0, L), result.u).z();
  // Ten quadratic elements are within 0.2 % of the limit; the shear coefficient 5/6 and the warping
  // suppressed at the clamp leave as much of a shear part that is 0.8 % here.
  EXPECT_NEAR(sag, expected, 3e-3 * expected);
}

TEST(StaticSolve, PulledPointGoesWhereItIsToldAndIsFreeAcross) {
  const Cantilever rig;
  StaticLoad load;
  load.pulled_point = rig.tip;
  load.pull = {0.001, 0.0005, -0.006};
  const StaticResult result = solve_static(rig.body, rig.held, load);
  ASSERT_TRUE(result.usable()) << result.message;
  const Eigen::Vector3d along = load.pull.normalized();
  // The constraint is linear and kept exactly; round-off of a 6 mm displacement.
  EXPECT_NEAR(interpolate(rig.tip, result.u).dot(along), load.pull.norm(), 1e-13);
  // Free across: it does not simply go along the pull.
  EXPECT_GT((interpolate(rig.tip, result.u) - load.pull).norm(), 1e-5);
  Eigen::VectorXd unbalanced =
      result.reaction - nodal_force(rig.body.mesh(), rig.tip, result.pull_force_n * along);
  for (const int node : rig.held) unbalanced.segment<3>(3 * node).setZero();
  // The only force on free nodes is the pull's, along it, to the solver's tolerance (1e-9).
  EXPECT_LT(unbalanced.norm(), 1e-8 * result.reaction.norm());
  EXPECT_GT(result.pull_force_n, 0.0);
}

TEST(StaticSolve, TheForceThatAPullReportsGivesTheSameState) {
  const Cantilever rig;
  StaticLoad pull;
  pull.pulled_point = rig.tip;
  pull.pull = {0.0, 0.002, -0.012};
  const StaticResult pulled = solve_static(rig.body, rig.held, pull);
  ASSERT_TRUE(pulled.usable()) << pulled.message;
  StaticLoad push;
  push.force = nodal_force(rig.body.mesh(), rig.tip, pulled.pull_force_n * pull.pull.normalized());
  const StaticResult pushed = solve_static(rig.body, rig.held, push);
  ASSERT_TRUE(pushed.usable()) << pushed.message;
  // Both are balanced to 1e-9 of the forces; a slender bar's bending is ~1e2 softer.
  EXPECT_LT((pulled.u - pushed.u).norm(), 1e-7 * pulled.u.norm());
}

TEST(StaticSolve, PullForceIsTheSlopeOfTheEnergy) {
  const Cantilever rig;
  const auto energy_at = [&](double distance) {
    StaticLoad load;
    load.pulled_point = rig.tip;
    load.pull = {0.0, 0.0, -distance};
    const StaticResult result = solve_static(rig.body, rig.held, load);
    EXPECT_TRUE(result.usable()) << result.message;
    return std::pair(rig.body.elastic_energy(result.u), result.pull_force_n);
  };
  const double distance = 0.01;
  const double step = 1e-5;
  const double slope =
      (energy_at(distance + step).first - energy_at(distance - step).first) / (2.0 * step);
  const double force = energy_at(distance).second;
  // Central difference: error (step/distance)^2 = 1e-6 of a nearly quadratic energy.
  EXPECT_NEAR(slope, force, 1e-5 * force);
}

TEST(StaticSolve, ReactionsBalanceTheLoad) {
  const Cantilever rig;
  StaticLoad load;
  load.force = rig.body.gravity_force({0.0, 3.0, -200.0}) +
               nodal_force(rig.body.mesh(), rig.tip, {0.3, -0.2, -1.0});
  const StaticResult result = solve_static(rig.body, rig.held, load);
  ASSERT_TRUE(result.usable()) << result.message;
  const int n = rig.body.mesh().num_nodes();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Vector3d applied = Eigen::Vector3d::Zero();
  for (int i = 0; i < n; ++i) sum += result.reaction.segment<3>(3 * i);
  for (int i = 0; i < n; ++i) applied += load.force.segment<3>(3 * i);
  // Internal forces sum to zero to round-off, the residual is below 1e-9 of the nodal forces.
  EXPECT_LT((sum + applied).norm(), 1e-6 * applied.norm());
}

TEST(StaticSolve, EquilibriumToStartFromNeedsNoIteration) {
  const Cantilever rig;
  StaticLoad load;
  load.force = rig.body.gravity_force({0.0, 0.0, -300.0});
  const StaticResult first = solve_static(rig.body, rig.held, load);
  ASSERT_TRUE(first.usable()) << first.message;
  EXPECT_GT(first.newton_iterations, 0);
  const StaticResult again = solve_static(rig.body, rig.held, load, {}, first.u);
  ASSERT_TRUE(again.usable()) << again.message;
  EXPECT_EQ(again.newton_iterations, 0);
  EXPECT_EQ(again.u, first.u);
}

TEST(StaticSolve, UnloadingFromADeflectedStateReturnsToRest) {
  const Cantilever rig;
  StaticLoad pull;
  pull.pulled_point = rig.tip;
  pull.pull = {0.0, 0.0, -0.02};
  const StaticResult pulled = solve_static(rig.body, rig.held, pull);
  ASSERT_TRUE(pulled.usable()) << pulled.message;
  const StaticResult rest = solve_static(rig.body, rig.held, {}, {}, pulled.u);
  ASSERT_TRUE(rest.usable()) << rest.message;
  // Residual 1e-9 of the forces met on the way; the softest mode amplifies it.
  EXPECT_LT(rest.u.norm(), 1e-6 * pulled.u.norm());
}

TEST(StaticSolve, LoadStepsAreHalvedUntilNewtonConverges) {
  const Cantilever rig;
  StaticLoad load;
  load.pulled_point = rig.tip;
  load.pull = {-0.02, 0.0, -0.045};
  const StaticResult at_once = solve_static(rig.body, rig.held, load);
  ASSERT_TRUE(at_once.usable()) << at_once.message;
  StaticOptions patient;
  patient.load_steps = 20;
  const StaticResult in_steps = solve_static(rig.body, rig.held, load, patient);
  ASSERT_TRUE(in_steps.usable()) << in_steps.message;
  EXPECT_GE(in_steps.load_steps, 20);
  // The same branch of equilibria, each state balanced to 1e-9.
  EXPECT_LT((at_once.u - in_steps.u).norm(), 1e-6 * in_steps.u.norm());
}

TEST(StaticSolve, LoadThatNothingBalancesEndsInASentence) {
  const ElasticBody body(box_mesh(ElementKind::Hex8, {3, 1, 1}, {0.03, 0.01, 0.01}),
                         {material(1e9, 0.4, 1200.0)});
  StaticLoad load;
  load.pulled_point = locate(body.mesh(), {0.03, 0.005, 0.005});
  load.pull = {-0.3, 0.0, 0.0};  // far through the clamp
  StaticOptions options;
  options.max_newton_iterations = 8;
  const StaticResult result = solve_static(body, nodes_at(body.mesh(), 0, 0.0), load, options);
  EXPECT_TRUE(result.u.allFinite());
  EXPECT_TRUE(std::isfinite(result.pull_force_n));
  EXPECT_TRUE(std::isfinite(body.elastic_energy(result.u)));
  EXPECT_EQ(result.termination, Termination::NumericalFailure);
  EXPECT_LT(result.load_fraction, 1.0);
  EXPECT_NE(result.message.find("no equilibrium"), std::string::npos) << result.message;
}

TEST(StaticSolve, ProgressThatSaysNoCancels) {
  const Cantilever rig;
  StaticLoad load;
  load.force = rig.body.gravity_force({0.0, 0.0, -300.0});
  StaticOptions options;
  options.progress = [](const Progress&) { return false; };
  EXPECT_THROW(static_cast<void>(solve_static(rig.body, rig.held, load, options)), Cancelled);
}

TEST(StaticSolve, RefusesWhatCannotBeSolved) {
  const Cantilever rig;
  const auto refused = [&](const std::vector<int>& held,
                           const StaticLoad& load,
                           const StaticOptions& options = {},
                           const Eigen::VectorXd& start = {}) {
    EXPECT_THROW(static_cast<void>(solve_static(rig.body, held, load, options, start)), InputError);
  };
  refused({}, {});
  StaticLoad short_force;
  short_force.force = Eigen::VectorXd::Zero(3);
  refused(rig.held, short_force);
  StaticLoad nowhere;
  nowhere.pulled_point = rig.tip;
  refused(rig.held, nowhere);
  StaticLoad stuck;
  stuck.pulled_point = locate(rig.body.mesh(), {0.0, 0.004, 0.002});
  stuck.pull = {0.0, 0.0, 1e-3};
  refused(rig.held, stuck);
  refused(rig.held, {}, {}, Eigen::VectorXd::Zero(5));
  StaticOptions loose;
  loose.tolerance = 1.0;
  refused(rig.held, {}, loose);
  StaticOptions hasty;
  hasty.max_newton_iterations = 0;
  refused(rig.held, {}, hasty);
  StaticOptions no_steps;
  no_steps.load_steps = 0;
  refused(rig.held, {}, no_steps);
}

}  // namespace
}  // namespace twang
