// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/integrators.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "simulate/detail/state_stream.hpp"
#include "simulate/energy.hpp"
#include "tests/simulate/moving_block.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace twang {
namespace {

using test::block;
using test::fitted_order;
using test::moving;
using test::nodes_at;
using test::rubber;

IntegratorOptions tight(Scheme scheme, double step_s) {
  IntegratorOptions options;
  options.step_s = step_s;
  options.tolerance = 1e-11;
  options.scheme = scheme;
  return options;
}

struct SchemeCase {
  Scheme scheme;
  int coarsest;  // number of steps
  double order;
};

class SchemeTest : public testing::TestWithParam<SchemeCase> {};

Eigen::VectorXd end_of(const ElasticBody& body, Scheme scheme, int steps) {
  const double duration = 4e-3;
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  BodyState state = moving(body.mesh(), 1.0);
  Integrator integrator(body, held, tight(scheme, duration / steps));
  const RunSummary summary = run(integrator, state, duration / steps, duration, {});
  EXPECT_TRUE(summary.usable()) << summary.message;
  return state.u;
}

TEST_P(SchemeTest, ConvergesWithItsOrder) {
  const ElasticBody body = block(rubber(2e-4, 3.0), ConstitutiveModel::NeoHookean, {3, 1, 1});
  // Of order two: its error is below a hundredth of the smallest one fitted.
  const Eigen::VectorXd exact = end_of(body, Scheme::Newmark, 4096);
  std::vector<double> steps;
  std::vector<double> errors;
  for (const int factor : {1, 2, 4}) {
    const int n = GetParam().coarsest * factor;
    steps.push_back(1.0 / n);
    errors.push_back((end_of(body, GetParam().scheme, n) - exact).norm());
  }
  const double order = fitted_order(steps, errors);
  std::printf("%s: order %.3f\n", std::string(to_string(GetParam().scheme)).c_str(), order);
  EXPECT_NEAR(order, GetParam().order, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Schemes,
                         SchemeTest,
                         testing::Values(SchemeCase{Scheme::Newmark, 64, 2.0},
                                         SchemeCase{Scheme::ImplicitEuler, 512, 1.0},
                                         SchemeCase{Scheme::Bdf2, 128, 2.0},
                                         SchemeCase{Scheme::LinearlyImplicitNewmark, 64, 2.0}),
                         [](const auto& instance) {
                           return std::string(to_string(instance.param.scheme));
                         });

TEST(Scheme, NamesReadBack) {
  for (const Scheme scheme :
       {Scheme::Newmark, Scheme::ImplicitEuler, Scheme::Bdf2, Scheme::LinearlyImplicitNewmark})
    EXPECT_EQ(scheme_from(to_string(scheme)), scheme);
  EXPECT_THROW(static_cast<void>(scheme_from("newmrk")), InputError);
}

TEST(Scheme, AllAreExactAboutARigidFlight) {
  // Constant velocity, no force: every scheme carries it on without an error.
  const ElasticBody body = block(rubber(1e-4));
  for (const Scheme scheme :
       {Scheme::Newmark, Scheme::ImplicitEuler, Scheme::Bdf2, Scheme::LinearlyImplicitNewmark}) {
    BodyState state = moving(body.mesh(), 0.0);
    for (int i = 0; i < body.mesh().num_nodes(); ++i)
      state.v.segment<3>(3 * i) = Eigen::Vector3d(1.0, -2.0, 3.0);
    Integrator integrator(body, {}, tight(scheme, 1e-3));
    ASSERT_TRUE(run(integrator, state, 1e-3, 0.02, {}).usable());
    for (int i = 0; i < body.mesh().num_nodes(); ++i)
      // round-off of twenty sums of centimetres
      EXPECT_LT((state.u.segment<3>(3 * i) - 0.02 * Eigen::Vector3d(1.0, -2.0, 3.0)).norm(), 1e-12);
  }
}

TEST(Scheme, ImplicitEulerAndBdf2TakeEnergyFromAnUndampedBody) {
  const ElasticBody body = block(rubber(), ConstitutiveModel::Linear);
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  const auto left_of = [&](Scheme scheme) {
    BodyState state = moving(body.mesh(), 1.0);
    const double start = measure_energy(body, state).total_j();
    Integrator integrator(body, held, tight(scheme, 2e-4));
    EXPECT_TRUE(run(integrator, state, 2e-4, 0.04, {}).usable());
    return measure_energy(body, state).total_j() / start;
  };
  const double euler = left_of(Scheme::ImplicitEuler);
  const double bdf2 = left_of(Scheme::Bdf2);
  EXPECT_LT(euler, 0.5);  // its slowest mode alone loses omega h = 4 % a step of 200
  EXPECT_LT(bdf2, 0.999);
  EXPECT_GT(bdf2, euler);
  // 200 steps with residuals of 1e-11 of the forces
  EXPECT_NEAR(left_of(Scheme::Newmark), 1.0, 1e-9);
}

TEST(Integrator, AStepThatDoesNotConvergeIsHalved) {
  const ElasticBody body = block(rubber(1e-4));
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  IntegratorOptions options = tight(Scheme::Newmark, 2e-4);
  options.max_newton_iterations = 3;  // too few for so tight a tolerance in one step
  options.max_halvings = 0;
  BodyState whole = moving(body.mesh(), 3.0);
  Integrator without(body, held, options);
  ASSERT_NE(without.step(whole).termination, Termination::Converged);

  options.max_halvings = 10;
  Integrator with(body, held, options);
  BodyState state = moving(body.mesh(), 3.0);
  const StepReport report = with.step(state);
  ASSERT_EQ(report.termination, Termination::Converged) << report.message;
  EXPECT_GT(report.substeps, 1);
  EXPECT_DOUBLE_EQ(state.time_s, 2e-4);

  // Halves are nearer to the truth than the whole step, and are not the truth.
  options.max_newton_iterations = 30;
  Integrator patient(body, held, options);
  BodyState one_step = moving(body.mesh(), 3.0);
  const StepReport whole_report = patient.step(one_step);
  ASSERT_EQ(whole_report.termination, Termination::Converged);
  ASSERT_EQ(whole_report.substeps, 1);
  Integrator fine(body, held, tight(Scheme::Newmark, 2e-4 / 64));
  BodyState exact = moving(body.mesh(), 3.0);
  ASSERT_TRUE(run(fine, exact, 2e-4 / 64, 2e-4, {}).usable());
  const double error = (state.u - exact.u).norm();
  EXPECT_LT(error, 0.6 * (one_step.u - exact.u).norm());
  EXPECT_GT(error, 0.0);
}

TEST(Integrator, RestoredGoesOnBitByBit) {
  const ElasticBody body = block(rubber(1e-4));
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  for (const Scheme scheme : {Scheme::Newmark, Scheme::Bdf2, Scheme::LinearlyImplicitNewmark}) {
    IntegratorOptions options;
    options.step_s = 2e-4;
    options.scheme = scheme;
    const Eigen::VectorXd load = body.gravity_force({0.0, 3.0, -9.81});
    Integrator first(body, held, options, load);
    BodyState a = moving(body.mesh(), 2.0);
    for (int i = 0; i < 23; ++i) ASSERT_EQ(first.step(a).termination, Termination::Converged);
    detail::StateWriter writer;
    first.save(writer);
    BodyState b = a;

    Integrator second(body, held, options);  // its load is restored too
    detail::StateReader reader(writer.bytes(), "memory");
    second.restore(reader);
    EXPECT_TRUE(reader.at_end());
    for (int i = 0; i < 23; ++i) {
      ASSERT_EQ(first.step(a).termination, Termination::Converged);
      ASSERT_EQ(second.step(b).termination, Termination::Converged);
    }
    EXPECT_EQ(a.u, b.u);
    EXPECT_EQ(a.v, b.v);
  }
}

TEST(Integrator, RefusesTheMemoryOfAnotherBody) {
  const ElasticBody body = block(rubber(1e-4));
  Integrator first(body, {}, {});
  BodyState state = moving(body.mesh(), 1.0);
  ASSERT_EQ(first.step(state).termination, Termination::Converged);
  detail::StateWriter writer;
  first.save(writer);
  const ElasticBody other = block(rubber(1e-4), ConstitutiveModel::NeoHookean, {3, 1, 1});
  Integrator second(other, {}, {});
  detail::StateReader reader(writer.bytes(), "memory");
  EXPECT_THROW(second.restore(reader), InputError);
  detail::StateReader cut(std::string_view(writer.bytes()).substr(0, 100), "memory");
  EXPECT_THROW(first.restore(cut), InputError);
}

TEST(Integrator, BaseThatMovesRigidlyCarriesAStiffBody) {
  ElasticMaterial stiff = rubber(1e-5);
  stiff.youngs_modulus_pa = 1e12;
  const ElasticBody body = block(stiff);
  const std::vector<int> held = nodes_at(body.mesh(), 0, 0.0);
  for (const Scheme scheme : {Scheme::Newmark, Scheme::ImplicitEuler, Scheme::Bdf2}) {
    const double h = 1e-3;
    Integrator integrator(body, held, tight(scheme, h));
    BodyState state = moving(body.mesh(), 0.0);
    // x'' = 2 m/s² for 50 steps, z at a constant rate after the first step
    for (int i = 1; i <= 50; ++i) {
      integrator.set_base_velocity({2.0 * i * h, 0.0, 0.1});
      ASSERT_EQ(integrator.step(state).termination, Termination::Converged);
    }
    const Eigen::Vector3d held_u = state.u.segment<3>(3 * held.front());
    // The rules' own sums of v: exact for the trapezoidal one but for the jump of z at the start.
    EXPECT_NEAR(held_u.x(), 0.5 * 2.0 * 0.05 * 0.05, 2.0 * h * 0.05);
    EXPECT_NEAR(held_u.z(), 0.1 * 0.05, 0.1 * h);
    // rho L² a / E = 2e-12 m is how far the body gives; its mode's overshoot doubles it
    for (int i = 0; i < body.mesh().num_nodes(); ++i)
      EXPECT_LT((state.u.segment<3>(3 * i) - held_u).norm(), 1e-8);
  }
}

}  // namespace
}  // namespace twang
