// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "fem/static_solve.hpp"
#include "simulate/energy.hpp"
#include "simulate/integrators.hpp"
#include "tests/simulate/moving_block.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using test::block;
using test::nodes_at;
using test::rubber;

constexpr double kStep = 2e-4;  // [s]

IntegratorOptions held_steps(Scheme scheme) {
  IntegratorOptions options;
  options.step_s = kStep;
  options.tolerance = 1e-10;
  options.scheme = scheme;
  return options;
}

TEST(HeldPoint, StaysWhereItIsWhileTheRestIsShakenAndGoesWhenItIsLetGo) {
  const ElasticBody body = block(rubber(1e-4));
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  const MeshPoint first = locate(body.mesh(), {0.03, 0.005, 0.005});
  const MeshPoint second = locate(body.mesh(), {0.02, 0.005, 0.01});
  StaticLoad pull;
  pull.more_pulls = {{first, {0.0, 0.0, 0.004}}, {second, {0.0, 0.001, 0.0}}};
  const StaticResult start = solve_static(body, held, pull);
  ASSERT_TRUE(start.usable()) << start.message;
  ASSERT_EQ(start.pull_forces_n.size(), 2U);
  for (const Scheme scheme :
       {Scheme::Newmark, Scheme::ImplicitEuler, Scheme::Bdf2, Scheme::LinearlyImplicitNewmark}) {
    BodyState state{start.u, Eigen::VectorXd::Zero(start.u.size()), 0.0};
    Integrator integrator(body, held, held_steps(scheme));
    integrator.hold_points({{first, Eigen::Vector3d::UnitZ()}, {second, Eigen::Vector3d::UnitY()}});
    // At rest as it was left: residuals of 1e-9 of the static forces.
    for (int i = 0; i < 4; ++i)
      ASSERT_EQ(integrator.step(state).termination, Termination::Converged);
    EXPECT_LT((state.u - start.u).norm(), 1e-6 * start.u.norm());
    // Shaken and with the second point gone, the first stays to round-off and slides across.
    integrator.set_external_force(body.gravity_force({0.0, 300.0, -300.0}));
    integrator.hold_points({{first, Eigen::Vector3d::UnitZ()}});
    for (int i = 0; i < 12; ++i) {
      const StepReport report = integrator.step(state);
      ASSERT_EQ(report.termination, Termination::Converged) << report.message;
      EXPECT_NEAR(interpolate(first, state.u).z(), 0.004, 1e-13);
    }
    EXPECT_GT(std::abs(interpolate(first, state.u - start.u).y()), 1e-4);
    integrator.hold_points({});
    for (int i = 0; i < 4; ++i)
      ASSERT_EQ(integrator.step(state).termination, Termination::Converged);
    EXPECT_LT(interpolate(first, state.u).z(), 0.0039);
  }
}

TEST(HeldPoint, MovedPointDoesTheWorkThatIsFoundAgain) {
  const ElasticBody body = block(rubber(1e-4), ConstitutiveModel::Linear);
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  const MeshPoint point = locate(body.mesh(), {0.03, 0.005, 0.005});
  Integrator integrator(body, held, held_steps(Scheme::Newmark));
  integrator.hold_points({{point, Eigen::Vector3d::UnitZ()}});
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(body.mesh().num_dofs());
  BodyState state{nothing, nothing, 0.0};
  double work = 0.0;
  constexpr int kSteps = 20;
  constexpr double kDistance = 0.003;
  for (int i = 1; i <= kSteps; ++i) {
    const double speed = (1.0 - std::cos(kTwoPi * i / kSteps)) * kDistance / (kSteps * kStep);
    integrator.set_point_velocities(Eigen::VectorXd::Constant(1, speed));
    const StepReport report = integrator.step(state);
    ASSERT_EQ(report.termination, Termination::Converged) << report.message;
    work += report.work.points_j - report.work.damping_j;
  }
  // The trapezoidal rule adds a whole period of the cosine up exactly.
  EXPECT_NEAR(interpolate(point, state.u).z(), kDistance, 1e-12);
  const double energy = measure_energy(body, state).total_j();
  EXPECT_GT(energy, 0.0);
  EXPECT_NEAR(work, energy, 1e-7 * energy);  // 20 residuals of 1e-10 of the forces
}

TEST(HeldPoint, RefusesPointsThatCannotBeHeld) {
  const ElasticBody body = block(rubber());
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  Integrator integrator(body, held, held_steps(Scheme::Newmark));
  const HeldPoint end{locate(body.mesh(), {0.03, 0.005, 0.005}), Eigen::Vector3d::UnitZ()};
  EXPECT_THROW(integrator.hold_points({end, end}), InputError);
  EXPECT_THROW(integrator.hold_points({{locate(body.mesh(), {0.0, 0.0, 0.0}), end.direction}}),
               InputError);
  integrator.hold_points({end});
  EXPECT_THROW(integrator.set_point_velocities(Eigen::VectorXd::Zero(2)), InputError);
}

TEST(Newmark, NearlyIncompressibleBodiesMoveOrEndInASentence) {
  ElasticMaterial material = rubber();
  material.poissons_ratio = 0.4999;
  for (const double b : {0.0, 1e-4}) {
    material.damping_stiffness_b_s = b;
    const ElasticBody body = block(material);
    const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
    StaticLoad pull;
    pull.pulled_point = locate(body.mesh(), {0.03, 0.005, 0.005});
    pull.pull = {0.0, 0.0, 0.003};  // a tenth of the length
    const StaticResult start = solve_static(body, held, pull);
    ASSERT_TRUE(start.usable()) << start.message;
    BodyState state{start.u, Eigen::VectorXd::Zero(start.u.size()), 0.0};
    const double energy = measure_energy(body, state).total_j();
    IntegratorOptions options;
    options.step_s = kStep;
    Integrator integrator(body, held, options);
    const RunSummary summary = run(integrator, state, kStep, 20 * kStep, {});
    EXPECT_TRUE(state.u.allFinite() && state.v.allFinite());
    if (b == 0.0) {
      ASSERT_TRUE(summary.usable()) << summary.message;
      // Of order h² in the motion that the steps resolve; it neither grows nor is lost.
      EXPECT_NEAR(measure_energy(body, state).total_j(), energy, 0.05 * energy);
    } else if (!summary.usable()) {
      EXPECT_NE(summary.message.find("Poisson's ratio"), std::string::npos) << summary.message;
    }
  }
}

}  // namespace
}  // namespace twang
