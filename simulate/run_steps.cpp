// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "simulate/integrators.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

namespace twang {
namespace {

constexpr double kWholeSteps = 1e-9;  // slack of duration / step, round-off of a quotient [-]

}  // namespace

StepPhases& StepPhases::operator+=(const StepPhases& other) {
  forces_s += other.forces_s;
  products_s += other.products_s;
  factorization_s += other.factorization_s;
  preconditioner_s += other.preconditioner_s;
  return *this;
}

StepWork& StepWork::operator+=(const StepWork& other) {
  load_j += other.load_j;
  base_j += other.base_j;
  damping_j += other.damping_j;
  points_j += other.points_j;
  return *this;
}

void RunSummary::add(const StepReport& report) {
  newton_iterations += report.newton_iterations;
  linear_iterations += report.linear_iterations;
  factorizations += report.factorizations;
  phases += report.phases;
  if (report.substeps > 1) ++halved_steps;
}

int count_steps(double duration_s, double step_s) {
  if (!(duration_s >= 0.0 && duration_s / step_s < 2e9))
    throw InputError(
        fmt::format("duration_s is {}, must be >= 0 and less than 2e9 steps", duration_s));
  return static_cast<int>(std::ceil(duration_s / step_s - kWholeSteps));
}

RunSummary run(Integrator& integrator,
               BodyState& state,
               double step_s,
               double duration_s,
               const std::function<void(const BodyState&)>& observe,
               const ProgressCallback& progress) {
  if (step_s != integrator.options().step_s)
    throw InputError(fmt::format(
        "step_s is {}, must be the integrator's {}", step_s, integrator.options().step_s));
  const int num_steps = count_steps(duration_s, step_s);
  const auto begin = std::chrono::steady_clock::now();
  const double start_s = state.time_s;
  RunSummary summary;
  summary.termination = Termination::Converged;
  if (observe) observe(state);
  for (int i = 1; i <= num_steps; ++i) {
    report_progress(progress, {"simulating", (i - 1) * step_s, duration_s});
    const StepReport report = integrator.step(state);
    summary.add(report);
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
