// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/energy_ledger.hpp"

#include "fem/static_solve.hpp"
#include "simulate/energy.hpp"
#include "simulate/integrators.hpp"
#include "tests/simulate/moving_block.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace twang {
namespace {

using test::block;
using test::fitted_order;
using test::moving;
using test::nodes_at;
using test::rubber;

/// Runs a loaded, damped, shaken block for a while; the largest remainder over the largest energy.
struct Account {
  double remainder = 0.0;
  double external = 0.0;
  double damping = 0.0;
};

Account account_of(
    const ElasticBody& body, Scheme scheme, double step_s, double duration_s, bool shaken) {
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  IntegratorOptions options;
  options.step_s = step_s;
  options.tolerance = 1e-11;
  options.scheme = scheme;
  const Eigen::VectorXd load = body.gravity_force({2.0, 5.0, -40.0});
  Integrator integrator(body, held, options, load);
  BodyState state = moving(body.mesh(), 1.0);
  EnergyLedger ledger;
  double largest = 0.0;
  double remainder = 0.0;
  bool first = true;
  const int steps = static_cast<int>(std::lround(duration_s / step_s));
  for (int i = 0; i <= steps; ++i) {
    if (i > 0) {
      if (shaken)
        integrator.set_base_velocity(Eigen::Vector3d(0.0, 0.2, 0.5) * std::sin(300.0 * i * step_s));
      const StepReport report = integrator.step(state);
      EXPECT_EQ(report.termination, Termination::Converged) << report.message;
      ledger.add({report.work.load_j + report.work.base_j, report.work.damping_j});
    }
    const BodyEnergy energy = measure_energy(body, state);
    MechanicalState now;
    now.kinetic_j = energy.kinetic_j;
    now.elastic_j = energy.elastic_j;
    if (first) ledger = EnergyLedger(now);
    first = false;
    largest = std::max(largest, now.total_j());
    remainder = std::max(remainder, std::abs(ledger.remainder_j(now)));
  }
  return {
      remainder / largest, ledger.work().external_j / largest, ledger.work().damping_j / largest};
}

TEST(EnergyLedger, ClosesForALinearBody) {
  const ElasticBody body = block(rubber(2e-4, 3.0), ConstitutiveModel::Linear);
  for (const bool shaken : {false, true}) {
    const Account account = account_of(body, Scheme::Newmark, 2e-4, 0.04, shaken);
    std::printf("remainder of a linear body: %.1e of the peak\n", account.remainder);
    // The claim is 1e-8 of the peak; the residual of each of 200 steps is 1e-11 of the forces.
    EXPECT_LT(account.remainder, 1e-8);
    // There was something to account for.
    EXPECT_GT(account.damping, 0.2);
    EXPECT_GT(std::abs(account.external), 0.01);
  }
}

TEST(EnergyLedger, RemainderOfANeoHookeanBodyIsOfOrderTwo) {
  const ElasticBody body = block(rubber(2e-4, 3.0), ConstitutiveModel::NeoHookean, {3, 1, 1});
  std::vector<double> steps;
  std::vector<double> remainders;
  for (const double h : {4e-5, 2e-5, 1e-5}) {
    steps.push_back(h);
    remainders.push_back(account_of(body, Scheme::Newmark, h, 0.008, true).remainder);
  }
  EXPECT_GT(remainders.back(), 1e-9);  // it is the rule's, not round-off
  EXPECT_LT(remainders.front(), 1e-2);
  const double order = fitted_order(steps, remainders);
  std::printf("remainder of a neo-Hookean body: %.1e at h = 4e-5 s, order %.3f\n",
              remainders.front(),
              order);
  EXPECT_NEAR(order, 2.0, 0.1);
}

TEST(EnergyLedger, RemainderOfImplicitEulerIsTheEnergyItLoses) {
  const ElasticBody body = block(rubber(), ConstitutiveModel::Linear);
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  IntegratorOptions options;
  options.step_s = 2e-4;
  options.tolerance = 1e-11;
  options.scheme = Scheme::ImplicitEuler;
  Integrator integrator(body, held, options);
  BodyState state = moving(body.mesh(), 1.0);
  // ½ (v1 - v0)ᵀ M (v1 - v0) + ½ (u1 - u0)ᵀ K (u1 - u0), step by step
  double lost = 0.0;
  const double start = measure_energy(body, state).total_j();
  for (int i = 0; i < 50; ++i) {
    const BodyState before = state;
    ASSERT_EQ(integrator.step(state).termination, Termination::Converged);
    const Eigen::VectorXd dv = state.v - before.v;
    const Eigen::VectorXd du = state.u - before.u;
    lost += 0.5 * dv.dot(body.mass() * dv) + 0.5 * du.dot(body.internal_force(du));
  }
  MechanicalState now;
  now.kinetic_j = measure_energy(body, state).kinetic_j;
  now.elastic_j = measure_energy(body, state).elastic_j;
  const EnergyLedger ledger(start, {});
  // 50 residuals of 1e-11 of the forces
  EXPECT_NEAR(ledger.remainder_j(now), lost, 1e-9 * start);
  EXPECT_GT(lost, 0.1 * start);
}

TEST(EnergyLedger, CountsEachWorkOnItsOwnSide) {
  MechanicalState start;
  start.kinetic_j = 1.0;
  start.elastic_j = 2.0;
  start.gravity_j = -4.0;
  EnergyLedger ledger(start);
  ledger.add({10.0, 1.0, 2.0, 3.0});
  ledger.add({1.0, 0.5, 0.25, 0.125});
  MechanicalState now = start;
  now.elastic_j += 4.0;
  EXPECT_DOUBLE_EQ(ledger.remainder_j(now), 11.0 - 1.5 - 2.25 - 3.125 - 4.0);
}

TEST(Momentum, AngularMomentumOfATumblingBodyIsKeptToOrderTwo) {
  const ElasticBody body = block(rubber(), ConstitutiveModel::NeoHookean, {3, 1, 1});
  std::vector<double> steps;
  std::vector<double> errors;
  for (const double h : {4e-4, 2e-4, 1e-4}) {
    BodyState state = moving(body.mesh(), 2.0);
    const Eigen::Vector3d spin(30.0, 100.0, -60.0);
    for (int i = 0; i < body.mesh().num_nodes(); ++i)
      state.v.segment<3>(3 * i) += spin.cross(body.mesh().nodes.col(i));
    const Eigen::Vector3d start = measure_momentum(body, state).angular;
    IntegratorOptions options;
    options.step_s = h;
    options.tolerance = 1e-11;
    Integrator integrator(body, {}, options);
    double squares = 0.0;
    int count = 0;
    const RunSummary summary = run(integrator, state, h, 0.02, [&](const BodyState& s) {
      squares += (measure_momentum(body, s).angular - start).squaredNorm();
      ++count;
    });
    ASSERT_TRUE(summary.usable()) << summary.message;
    steps.push_back(h);
    errors.push_back(std::sqrt(squares / count) / start.norm());
  }
  EXPECT_LT(errors.front(), 0.05);
  const double order = fitted_order(steps, errors);
  std::printf("angular momentum of a tumbling body: order %.3f\n", order);
  EXPECT_NEAR(order, 2.0, 0.1);
}

}  // namespace
}  // namespace twang
