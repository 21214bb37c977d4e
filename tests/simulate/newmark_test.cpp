// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "fem/static_solve.hpp"
#include "simulate/energy.hpp"
#include "simulate/integrators.hpp"
#include "tests/simulate/moving_block.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace twang {
namespace {

using test::block;
using test::box_mesh;
using test::fitted_order;
using test::moving;
using test::nodes_at;
using test::rubber;

NewmarkOptions tight(double step_s) {
  NewmarkOptions options;
  options.step_s = step_s;
  options.tolerance = 1e-11;
  return options;
}

BodyState simulated(const ElasticBody& body,
                    const std::vector<int>& held,
                    BodyState state,
                    double step_s,
                    double duration_s) {
  NewmarkIntegrator integrator(body, held, tight(step_s));
  const RunSummary summary = run(integrator, state, step_s, duration_s, {});
  EXPECT_TRUE(summary.usable()) << summary.message;
  return state;
}

TEST(Newmark, ConvergesWithOrderTwo) {
  const ElasticBody body = block(rubber(2e-4, 3.0), ConstitutiveModel::NeoHookean, {3, 1, 1});
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  const BodyState start = moving(body.mesh(), 1.0);
  const double duration = 4e-3;
  const BodyState exact = simulated(body, held, start, duration / 1024, duration);
  std::vector<double> steps;
  std::vector<double> errors;
  for (const int n : {32, 64, 128}) {
    steps.push_back(duration / n);
    errors.push_back((simulated(body, held, start, steps.back(), duration).u - exact.u).norm());
  }
  // The reference's own error is 1/64 of the smallest one.
  EXPECT_NEAR(fitted_order(steps, errors), 2.0, 0.1);
}

TEST(Newmark, SolvesItsOwnEquation) {
  // Two materials of different b, gravity, a: eqs. (1)-(3) put together from assembled matrices.
  HexMesh mesh = box_mesh(ElementKind::Hex8, {4, 2, 2}, {0.03, 0.01, 0.01});
  mesh.material_names = {"soft", "hard"};
  for (int e = 0; e < mesh.num_elements(); ++e)
    mesh.material_of_element[static_cast<std::size_t>(e)] = e % 2;
  ElasticMaterial hard = rubber(1e-4, 3.0);
  hard.youngs_modulus_pa *= 4.0;
  const ElasticBody body(mesh, {rubber(5e-4, 3.0), hard});
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  const double h = 2e-4;
  const Eigen::VectorXd gravity = body.gravity_force({0.0, 1.0, -9.81});
  NewmarkIntegrator integrator(body, held, tight(h), gravity);
  BodyState first = moving(body.mesh(), 1.0);
  ASSERT_EQ(integrator.step(first).termination, Termination::Converged);
  BodyState second = first;
  ASSERT_EQ(integrator.step(second).termination, Termination::Converged);

  const auto force = [&](const BodyState& s) -> Eigen::VectorXd {
    return gravity - body.internal_force(s.u) -
           (body.stiffness_damping(s.u) + 3.0 * body.mass()) * s.v;
  };
  const Eigen::VectorXd delta = second.u - first.u;
  const Eigen::VectorXd inertia = 4.0 / (h * h) * (body.mass() * (delta - h * first.v));
  const FreeDofs free(body.mesh().num_nodes(), held);
  const Eigen::VectorXd residual = free.restrict_vector(inertia - force(first) - force(second));
  // The tolerance is 1e-11 of the forces; sums in another order add some round-off.
  EXPECT_LT(residual.norm(), 1e-10 * force(first).norm());
  EXPECT_LT((second.v - (2.0 / h * delta - first.v)).norm(), 1e-13 * second.v.norm());
}

TEST(Newmark, LinearUndampedEnergyIsConstant) {
  const ElasticBody body = block(rubber(), ConstitutiveModel::Linear);
  BodyState state = moving(body.mesh(), 1.0);
  NewmarkIntegrator integrator(body, nodes_at(body.mesh(), 0, 0.0), tight(2e-4));
  const double start = measure_energy(body, state).total_j();
  double drift = 0.0;
  double most_elastic = 0.0;
  const RunSummary summary = run(integrator, state, 2e-4, 0.04, [&](const BodyState& s) {
    const BodyEnergy energy = measure_energy(body, s);
    drift = std::max(drift, std::abs(energy.total_j() - start));
    most_elastic = std::max(most_elastic, energy.elastic_j);
  });
  ASSERT_TRUE(summary.usable()) << summary.message;
  EXPECT_GT(most_elastic, 0.5 * start);
  std::printf("energy of a linear body: %.1e\n", drift / start);
  // 200 steps, each with a residual of at most 1e-11 of the forces.
  EXPECT_LT(drift, 1e-9 * start);
}

TEST(Newmark, NeoHookeanEnergyDriftIsOfOrderTwo) {
  const ElasticBody body = block(rubber(), ConstitutiveModel::NeoHookean, {3, 1, 1});
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  std::vector<double> steps;
  std::vector<double> drifts;
  for (const double h : {5e-5, 2.5e-5, 1.25e-5}) {
    BodyState state = moving(body.mesh(), 1.5);
    const double start = measure_energy(body, state).total_j();
    NewmarkIntegrator integrator(body, held, tight(h));
    double squares = 0.0;
    const RunSummary summary = run(integrator, state, h, 0.01, [&](const BodyState& s) {
      squares += std::pow(measure_energy(body, s).total_j() - start, 2);
    });
    ASSERT_TRUE(summary.usable()) << summary.message;
    steps.push_back(h);
    drifts.push_back(std::sqrt(squares / (summary.steps + 1)) / start);
  }
  // Small, but not zero as for a linear body.
  EXPECT_GT(drifts.back(), 1e-8);
  EXPECT_LT(drifts.front(), 1e-3);
  const double order = fitted_order(steps, drifts);
  std::printf("energy drift of a neo-Hookean body: order %.3f\n", order);
  EXPECT_NEAR(order, 2.0, 0.1);
}

TEST(Newmark, FreeBodyKeepsItsMomenta) {
  const ElasticBody body = block(rubber());
  BodyState state = moving(body.mesh(), 2.0);
  const Eigen::Vector3d spin(30.0, 100.0, -60.0);
  for (int i = 0; i < body.mesh().num_nodes(); ++i)
    state.v.segment<3>(3 * i) += spin.cross(body.mesh().nodes.col(i)) + Eigen::Vector3d(1, 2, 3);
  const double h = 2e-4;
  // Trapezoidal Newmark keeps sum m (q x v + h²/4 v x a), not the angular momentum itself.
  const auto kept = [&](const BodyState& s) {
    Eigen::Vector3d sum = measure_momentum(body, s).angular;
    const Eigen::VectorXd force = -body.internal_force(s.u);
    for (int i = 0; i < body.mesh().num_nodes(); ++i)
      sum += h * h / 4.0 *
             Eigen::Vector3d(s.v.segment<3>(3 * i)).cross(Eigen::Vector3d(force.segment<3>(3 * i)));
    return sum;
  };
  const BodyMomentum start = measure_momentum(body, state);
  const Eigen::Vector3d kept_start = kept(state);
  NewmarkIntegrator integrator(body, {}, tight(h));
  // 0.08 s: the body turns by 10 rad about its axis, so its factor must turn with it.
  const RunSummary summary = run(integrator, state, h, 0.08, {});
  ASSERT_TRUE(summary.usable()) << summary.message;
  const BodyMomentum end = measure_momentum(body, state);
  std::printf("discrete angular momentum of a tumbling body: %.1e\n",
              (kept(state) - kept_start).norm() / kept_start.norm());
  // Internal forces cancel to round-off; the residual of 400 steps is 1e-11 of them each.
  EXPECT_LT((end.linear - start.linear).norm(), 1e-9 * start.linear.norm());
  EXPECT_LT((kept(state) - kept_start).norm(), 1e-8 * kept_start.norm());
  EXPECT_LT(summary.factorizations, 40);
}

TEST(Newmark, EquilibriumUnderLoadStaysAtRest) {
  const ElasticBody body = block(rubber(1e-4));
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  StaticLoad load;
  load.force = body.gravity_force({0.0, 0.0, -50.0});
  StaticOptions options;
  options.tolerance = 1e-12;
  const StaticResult equilibrium = solve_static(body, held, load, options);
  ASSERT_TRUE(equilibrium.usable()) << equilibrium.message;
  BodyState state{equilibrium.u, Eigen::VectorXd::Zero(equilibrium.u.size()), 0.0};
  NewmarkIntegrator integrator(body, held, {1e-4, 1e-8, 30}, load.force);
  const RunSummary summary = run(integrator, state, 1e-4, 0.01, {});
  ASSERT_TRUE(summary.usable()) << summary.message;
  // What the static solution leaves unbalanced is all that can move it.
  EXPECT_LT((state.u - equilibrium.u).norm(), 1e-7 * equilibrium.u.norm());
}

TEST(Newmark, FreeFallFollowsTheParabola) {
  const ElasticBody body = block(rubber(1e-4));
  const Eigen::Vector3d g(0.0, 0.0, -9.81);
  BodyState state{Eigen::VectorXd::Zero(body.mesh().num_dofs()),
                  Eigen::VectorXd::Zero(body.mesh().num_dofs()),
                  0.0};
  NewmarkIntegrator integrator(body, {}, {1e-3, 1e-8, 30}, body.gravity_force(g));
  const RunSummary summary = run(integrator, state, 1e-3, 0.5, {});
  ASSERT_TRUE(summary.usable()) << summary.message;
  EXPECT_DOUBLE_EQ(state.time_s, 0.5);
  const Eigen::Vector3d fallen = 0.5 * 0.25 * g;
  // The scheme is exact for a constant acceleration; the tolerance is 1e-8 of the weight.
  for (int i = 0; i < body.mesh().num_nodes(); ++i)
    EXPECT_LT((state.u.segment<3>(3 * i) - fallen).norm(), 1e-7 * fallen.norm());
}

TEST(Newmark, AbsurdStepsEndInASentence) {
  const ElasticBody body = block(rubber(1e-4));
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  int failures = 0;
  for (const double speed : {3.0, 30.0, 1e4}) {
    for (const double h : {1e-3, 1.0, 1e3}) {
      BodyState state = moving(body.mesh(), speed);
      const BodyState before = state;
      NewmarkIntegrator integrator(body, held, {h, 1e-8, 12});
      const StepReport report = integrator.step(state);
      EXPECT_TRUE(state.u.allFinite() && state.v.allFinite());
      EXPECT_TRUE(std::isfinite(body.elastic_energy(state.u)));
      if (report.termination == Termination::Converged) continue;
      ++failures;
      EXPECT_FALSE(report.message.empty());
      EXPECT_EQ(state.u, before.u);
      EXPECT_EQ(state.v, before.v);
      EXPECT_EQ(state.time_s, before.time_s);
    }
  }
  EXPECT_GT(failures, 0);
}

TEST(Newmark, CrushingForceEndsInASentence) {
  const ElasticBody body = block(rubber());
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(body.mesh().num_dofs());
  for (const int node : nodes_at(body.mesh(), 0, 0.03)) force[3 * node] = -1e6;
  BodyState state = moving(body.mesh(), 0.0);
  NewmarkIntegrator integrator(body, held, {1e-3, 1e-8, 20}, force);
  const RunSummary summary = run(integrator, state, 1e-3, 0.02, {});
  EXPECT_TRUE(state.u.allFinite() && state.v.allFinite());
  EXPECT_TRUE(std::isfinite(body.elastic_energy(state.u)));
  EXPECT_FALSE(summary.message.empty());
  if (!summary.usable()) {
    EXPECT_NE(summary.message.find("failed"), std::string::npos);
  }
}

TEST(Newmark, StateThatIsInsideOutEndsInASentence) {
  const ElasticBody body = block(rubber(1e-4));
  BodyState state = moving(body.mesh(), 1.0);
  for (int i = 0; i < body.mesh().num_nodes(); ++i) state.u[3 * i] = -2.0 * body.mesh().nodes(0, i);
  const BodyState before = state;
  NewmarkIntegrator integrator(body, nodes_at(body.mesh(), 0, 0.0), {});
  const StepReport report = integrator.step(state);
  EXPECT_EQ(report.termination, Termination::NumericalFailure);
  EXPECT_NE(report.message.find("inside out"), std::string::npos) << report.message;
  EXPECT_EQ(state.u, before.u);
}

TEST(Newmark, AnotherStateForgetsTheHistory) {
  const ElasticBody body = block(rubber(1e-4));
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  NewmarkIntegrator used(body, held, tight(1e-4));
  BodyState elsewhere = moving(body.mesh(), 3.0);
  for (int i = 0; i < 5; ++i) ASSERT_EQ(used.step(elsewhere).termination, Termination::Converged);
  BodyState a = moving(body.mesh(), 1.0);
  ASSERT_EQ(used.step(a).termination, Termination::Converged);
  NewmarkIntegrator fresh(body, held, tight(1e-4));
  BodyState b = moving(body.mesh(), 1.0);
  ASSERT_EQ(fresh.step(b).termination, Termination::Converged);
  // Both solve the same equation to 1e-11 of the forces.
  EXPECT_LT((a.u - b.u).norm(), 1e-10 * b.u.norm());
}

TEST(Run, ObservesTheStartAndEveryStepAndCanBeStopped) {
  const ElasticBody body = block(rubber());
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  NewmarkIntegrator integrator(body, held, {});
  BodyState state = moving(body.mesh(), 1.0);
  std::vector<double> times;
  const RunSummary summary =
      run(integrator, state, 1e-4, 9.5e-4, [&](const BodyState& s) { times.push_back(s.time_s); });
  ASSERT_TRUE(summary.usable()) << summary.message;
  EXPECT_EQ(summary.steps, 10);
  ASSERT_EQ(times.size(), 11U);
  for (std::size_t i = 0; i < times.size(); ++i)
    EXPECT_DOUBLE_EQ(times[i], 1e-4 * static_cast<double>(i));
  EXPECT_GE(summary.newton_iterations, 10);
  EXPECT_GE(summary.linear_iterations, summary.newton_iterations);
  EXPECT_GE(summary.factorizations, 1);
  const auto no = [](const Progress& p) { return p.done < 3e-4; };
  EXPECT_THROW(run(integrator, state, 1e-4, 1e-3, {}, no), Cancelled);
}

TEST(Newmark, RefusesWhatCannotBeStepped) {
  const ElasticBody body = block(rubber());
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  const auto make = [&](const NewmarkOptions& options, const Eigen::VectorXd& force) {
    NewmarkIntegrator integrator(body, held, options, force);
  };
  EXPECT_THROW(make({0.0, 1e-8, 30}, {}), InputError);
  EXPECT_THROW(make({1e-4, 0.0, 30}, {}), InputError);
  EXPECT_THROW(make({1e-4, 1e-8, 0}, {}), InputError);
  EXPECT_THROW(make({}, Eigen::VectorXd::Zero(4)), InputError);
  EXPECT_THROW(NewmarkIntegrator(body, {body.mesh().num_nodes()}, {}), InputError);
  NewmarkIntegrator integrator(body, held, {});
  BodyState small{Eigen::VectorXd::Zero(3), Eigen::VectorXd::Zero(3), 0.0};
  EXPECT_THROW(static_cast<void>(integrator.step(small)), InputError);
  BodyState moved = moving(body.mesh(), 1.0);
  moved.v.segment<3>(3 * held.front()).setOnes();
  EXPECT_THROW(static_cast<void>(integrator.step(moved)), InputError);
  BodyState state = moving(body.mesh(), 1.0);
  EXPECT_THROW(run(integrator, state, 2e-4, 1e-2, {}), InputError);
  EXPECT_THROW(run(integrator, state, 1e-4, -1.0, {}), InputError);

  HexMesh mesh = box_mesh(ElementKind::Hex8, {2, 1, 1}, {0.02, 0.01, 0.01});
  mesh.material_names = {"one", "other"};
  mesh.material_of_element[1] = 1;
  const ElasticBody two(mesh, {rubber(1e-4, 1.0), rubber(1e-4, 2.0)});
  EXPECT_THROW(NewmarkIntegrator(two, {}, {}), InputError);
}

}  // namespace
}  // namespace twang
