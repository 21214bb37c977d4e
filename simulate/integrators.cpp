// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/integrators.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <deque>
#include <utility>

namespace twang {
namespace {

constexpr std::size_t kIncrementsKept = 5;
constexpr std::size_t kLargestOrder = 3;  // higher ones amplify what alternates
constexpr double kWholeSteps = 1e-9;      // slack of duration / step, round-off of a quotient [-]

void check_load(const ElasticBody& body, const Eigen::VectorXd& force) {
  if (force.size() != 0 && (force.size() != body.mesh().num_dofs() || !force.allFinite()))
    throw InputError(
        fmt::format("external_force has {} entries, must have {} finite ones (or none)",
                    force.size(),
                    body.mesh().num_dofs()));
}

/// The next increment if the last ones were a polynomial in time of degree below `order`, and, if
/// `alternating`, another that changes sign with each step: what the trapezoidal rule makes of very
/// stiff motion.
Eigen::VectorXd extrapolate(const std::deque<Eigen::VectorXd>& increments,
                            std::size_t order,
                            bool alternating) {
  // Coefficients of (1 - x)^order (1 + x), x the shift to the step before.
  std::vector<double> annihilator = {1.0};
  for (std::size_t factor = 0; factor < order + (alternating ? 1 : 0); ++factor) {
    annihilator.push_back(0.0);
    for (std::size_t i = annihilator.size() - 1; i > 0; --i)
      annihilator[i] += (factor < order ? -1.0 : 1.0) * annihilator[i - 1];
  }
  Eigen::VectorXd next = Eigen::VectorXd::Zero(increments.front().size());
  for (std::size_t i = 1; i < annihilator.size(); ++i) next -= annihilator[i] * increments[i - 1];
  return next;
}

}  // namespace

void NewmarkOptions::check() const {
  if (!(step_s > 0.0 && std::isfinite(step_s)))
    throw InputError(fmt::format("step_s is {}, must be > 0", step_s));
  if (!(tolerance > 0.0 && tolerance < 1.0))
    throw InputError(fmt::format("tolerance is {}, must lie between 0 and 1", tolerance));
  if (max_newton_iterations < 1)
    throw InputError(
        fmt::format("max_newton_iterations is {}, must be >= 1", max_newton_iterations));
}

struct NewmarkIntegrator::Impl {
  Impl(const ElasticBody& the_body,
       std::vector<int> held,
       const NewmarkOptions& newmark_options,
       Eigen::VectorXd force)
      : body(the_body),
        held_nodes(std::move(held)),
        options(newmark_options),
        external_force(std::move(force)),
        newton(body, held_nodes, {options.tolerance, options.max_newton_iterations}) {
    clear_held_load();
  }

  void clear_held_load() {
    if (external_force.size() == 0) external_force = Eigen::VectorXd::Zero(body.mesh().num_dofs());
    for (const int node : held_nodes) external_force.segment<3>(3 * node).setZero();
  }

  void check(const BodyState& state) const {
    const Eigen::Index dofs = body.mesh().num_dofs();
    if (state.u.size() != dofs || state.v.size() != dofs)
      throw InputError(fmt::format("the state has {} displacements and {} velocities, must have {}",
                                   state.u.size(),
                                   state.v.size(),
                                   dofs));
    for (const int node : held_nodes)
      if (state.v.segment<3>(3 * node) != Eigen::Vector3d::Zero())
        throw InputError(fmt::format("held node {} moves at {} m/s, must be at rest",
                                     node,
                                     state.v.segment<3>(3 * node).norm()));
  }

  [[nodiscard]] StepEquation equation(const BodyState& state,
                                      const Eigen::VectorXd& resisting_force) const {
    const double h = options.step_s;
    return {4.0 / (h * h),
            2.0 / h,
            state.u,
            h * state.v,
            -state.v,
            2.0 * external_force - resisting_force};
  }

  [[nodiscard]] std::vector<Eigen::VectorXd> guesses(const BodyState& state) const {
    const std::size_t count = increments.size();
    if (count == 0) return {options.step_s * state.v};
    std::vector<Eigen::VectorXd> candidates = {
        extrapolate(increments, std::min(count, kLargestOrder), false)};
    if (count > 1) candidates.push_back(extrapolate(increments, count - 1, true));
    return candidates;
  }

  const ElasticBody& body;
  const std::vector<int> held_nodes;
  const NewmarkOptions options;
  Eigen::VectorXd external_force;
  StepNewton newton;
  BodyState last;                          // as the last step returned it
  Eigen::VectorXd last_resisting_force;    // there [N]
  std::deque<Eigen::VectorXd> increments;  // of the last steps, latest first [m]
};

NewmarkIntegrator::NewmarkIntegrator(const ElasticBody& body,
                                     std::vector<int> held_nodes,
                                     NewmarkOptions options,
                                     Eigen::VectorXd external_force) {
  options.check();
  check_load(body, external_force);
  m_impl = std::make_unique<Impl>(body, std::move(held_nodes), options, std::move(external_force));
}
NewmarkIntegrator::~NewmarkIntegrator() = default;

const NewmarkOptions& NewmarkIntegrator::options() const { return m_impl->options; }

void NewmarkIntegrator::set_external_force(Eigen::VectorXd external_force) {
  check_load(m_impl->body, external_force);
  m_impl->external_force = std::move(external_force);
  m_impl->clear_held_load();
}

StepReport NewmarkIntegrator::step(BodyState& state) {
  Impl& impl = *m_impl;
  impl.check(state);
  const bool continued =
      impl.last.u.size() != 0 && state.u == impl.last.u && state.v == impl.last.v;
  if (!continued) {
    impl.increments.clear();
    impl.last_resisting_force = impl.newton.resisting_force(state.u, state.v);
  }
  const StepEquation equation = impl.equation(state, impl.last_resisting_force);
  StepSolution solution = impl.newton.solve(equation, impl.guesses(state));
  if (solution.report.termination != Termination::Converged) return solution.report;

  state.u += solution.delta;
  state.v = equation.gamma_per_s * solution.delta + equation.v_offset;
  for (const int node : impl.held_nodes) state.v.segment<3>(3 * node).setZero();
  state.time_s += impl.options.step_s;
  impl.increments.push_front(std::move(solution.delta));
  if (impl.increments.size() > kIncrementsKept) impl.increments.pop_back();
  impl.last_resisting_force = std::move(solution.resisting_force);
  impl.last = state;
  return solution.report;
}

RunSummary run(NewmarkIntegrator& integrator,
               BodyState& state,
               double step_s,
               double duration_s,
               const std::function<void(const BodyState&)>& observe,
               const ProgressCallback& progress) {
  if (step_s != integrator.options().step_s)
    throw InputError(fmt::format(
        "step_s is {}, must be the integrator's {}", step_s, integrator.options().step_s));
  if (!(duration_s >= 0.0 && duration_s / step_s < 2e9))
    throw InputError(
        fmt::format("duration_s is {}, must be >= 0 and less than 2e9 steps", duration_s));
  const auto num_steps = static_cast<int>(std::ceil(duration_s / step_s - kWholeSteps));
  const auto begin = std::chrono::steady_clock::now();
  const double start_s = state.time_s;
  RunSummary summary;
  summary.termination = Termination::Converged;
  if (observe) observe(state);
  for (int i = 1; i <= num_steps; ++i) {
    report_progress(progress, {"simulating", (i - 1) * step_s, duration_s});
    const StepReport report = integrator.step(state);
    summary.newton_iterations += report.newton_iterations;
    summary.linear_iterations += report.linear_iterations;
    summary.factorizations += report.factorizations;
    if (report.termination != Termination::Converged) {
      summary.termination = report.termination;
      summary.message = fmt::format("the step at {} s failed: {}; a step_s below {} may do",
                                    state.time_s,
                                    report.message,
                                    step_s);
      break;
    }
    state.time_s = start_s + i * step_s;
    summary.steps = i;
    if (observe) observe(state);
  }
  summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (summary.usable()) summary.message = fmt::format("{} steps of {} s", summary.steps, step_s);
  return summary;
}

}  // namespace twang
