// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/newton.hpp"

#include "core/constants.hpp"
#include "simulate/detail/minimal_residual.hpp"
#include "simulate/detail/state_stream.hpp"
#include "simulate/detail/step_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace twang {
namespace {

using detail::DampedBody;
using detail::PhaseTimer;

constexpr double kSufficientDecrease = 1e-4;          // of the merit's square root, per step [-]
constexpr double kSmallestStepLength = 1.0 / 1024.0;  // of the Newton step [-]
constexpr int kMaxLinearIterations = 60;              // before a new factor is the better buy
constexpr double kFirstForcing = 0.005;               // accuracy of the first linear solve [-]
constexpr double kLargestForcing = 0.3;               // of any
constexpr double kForcingMargin = 0.3;  // of the reduction that would just reach the tolerance [-]
constexpr int kMostMended = 3;          // steps that may mend what a Newton step spoils
constexpr double kMendingAccuracy = 1e-3;  // of their linear solves [-]
constexpr double kScaleMemory = 0.99;      // of the largest force met, a step [-]
constexpr double kRoundOff = 8.0 * std::numeric_limits<double>::epsilon();

}  // namespace

struct StepNewton::Impl {
  Impl(const ElasticBody& body, const std::vector<int>& held_nodes, NewtonOptions newton_options)
      : system(body, held_nodes, newton_options.solver), options(newton_options) {}

  /// A trial increment with all that follows from it.
  struct Trial {
    Eigen::VectorXd delta;
    Eigen::VectorXd u;
    Eigen::VectorXd v;
    Eigen::VectorXd resisting;
    Eigen::VectorXd residual;
    Eigen::VectorXd preconditioned;  // P⁻¹ r, empty until it is wanted
    double norm = kNaN;              // ‖r‖ [N]
    double scale = 0.0;              // largest force that takes part [N]
    [[nodiscard]] bool finite() const { return std::isfinite(norm); }
  };

  [[nodiscard]] Trial evaluate(const StepEquation& equation, Eigen::VectorXd delta) const {
    const PhaseTimer timer(system.phases.forces_s);
    Trial trial;
    trial.u = equation.u0 + delta;
    trial.v = equation.gamma_per_s * delta + equation.v_offset;
    const Eigen::VectorXd inertia =
        equation.mu_per_s2 * system.damped().mass_product(delta - equation.delta_free);
    trial.resisting = system.damped().resisting_force(trial.u, trial.v);
    trial.residual = system.off_points(inertia + trial.resisting - equation.load);
    trial.norm = trial.residual.norm();
    trial.scale = std::max({inertia.norm(), trial.resisting.norm(), equation.load.norm()});
    trial.delta = std::move(delta);
    return trial;
  }

  [[nodiscard]] Trial best_of(const StepEquation& equation,
                              const std::vector<Eigen::VectorXd>& guesses) const {
    Trial best = evaluate(equation, guesses.front());
    for (std::size_t i = 1; i < guesses.size(); ++i) {
      Trial trial = evaluate(equation, guesses[i]);
      if (!best.finite() || trial.norm < best.norm) best = std::move(trial);
    }
    if (!best.finite()) best = evaluate(equation, Eigen::VectorXd::Zero(equation.u0.size()));
    return best;
  }

  [[nodiscard]] DampedBody::Linearization linearize(const StepEquation& equation,
                                                    const Trial& trial) const {
    DampedBody::Linearization at;
    at.u = trial.u;
    at.v = trial.v;
    at.mu_per_s2 = equation.mu_per_s2;
    at.gamma_per_s = equation.gamma_per_s;
    at.differences = system.damped().stiff_in_volume();
    return at;
  }

  [[nodiscard]] bool renew(const DampedBody::Linearization& at, StepReport& report) {
    ++report.factorizations;
    return system.renew(at);
  }

  /// One Newton iteration; false and a sentence in the report if it cannot go on.
  bool iterate(
      const StepEquation& equation, double forcing, double goal, Trial& trial, StepReport& report);
  [[nodiscard]] static double merit_of(const Trial& trial);
  /// Whether a trial is at the goal or its merit at most so large.
  [[nodiscard]] bool good_enough(Trial& there, double merit, double goal) const;
  /// Goes along a Newton step as far as that lowers the merit; false if it does nowhere.
  bool go_along(const StepEquation& equation,
                DampedBody::Linearization at,
                const Eigen::VectorXd& direction,
                double goal,
                Trial& trial,
                StepReport& report) const;
  /// The whole Newton step to a relative accuracy; empty, with a sentence in the report, if it
  /// cannot be had.
  [[nodiscard]] Eigen::VectorXd linear_step(const StepEquation& equation,
                                            double accuracy,
                                            Trial& trial,
                                            StepReport& report);

  detail::StepSystem system;
  NewtonOptions options;
  double force_scale = 0.0;       // largest force met, slowly forgotten [N]
  double linear_reduction = 0.0;  // of the last linear solve [-]
};

double StepNewton::Impl::merit_of(const Trial& trial) {
  return std::sqrt(trial.residual.dot(trial.preconditioned));
}

bool StepNewton::Impl::good_enough(Trial& there, double merit, double goal) const {
  if (!there.finite()) return false;
  if (there.norm <= goal) return true;
  there.preconditioned = system.precondition(there.residual);
  return merit_of(there) <= merit;
}

bool StepNewton::Impl::go_along(const StepEquation& equation,
                                DampedBody::Linearization at,
                                const Eigen::VectorXd& direction,
                                double goal,
                                Trial& trial,
                                StepReport& report) const {
  const double merit = merit_of(trial);
  const double lower = (1.0 - kSufficientDecrease) * merit;
  Trial there = evaluate(equation, trial.delta + direction);
  // Volume changes by the square of a step; where that is stiff, the next step mends it, and only
  // both together are better than none [Maratos 1978; watchdog, Chamberlain et al. 1982].
  for (int mended = 0;; ++mended) {
    if (good_enough(there, lower, goal)) {
      trial = std::move(there);
      return true;
    }
    if (!there.finite() || mended == kMostMended) break;
    at.u = there.u;
    at.v = there.v;
    const auto linear = detail::minimal_residual(
        [&](const Eigen::VectorXd& w) { return system.product(at, w); },
        [this](const Eigen::VectorXd& r) { return system.precondition(r); },
        there.residual,
        there.preconditioned,
        kMendingAccuracy,
        kMaxLinearIterations);
    report.linear_iterations += linear.iterations;
    if (!linear.finite || !linear.converged) break;
    there = evaluate(equation, there.delta - linear.x);
  }
  for (double step = 0.5; step >= kSmallestStepLength; step *= 0.5) {
    there = evaluate(equation, trial.delta + step * direction);
    if (!good_enough(there, (1.0 - kSufficientDecrease * step) * merit, goal)) continue;
    trial = std::move(there);
    return true;
  }
  return false;
}

bool StepNewton::Impl::iterate(
    const StepEquation& equation, double forcing, double goal, Trial& trial, StepReport& report) {
  DampedBody::Linearization at = linearize(equation, trial);
  bool fresh = false;
  if (!system.factor().fits(at) || system.factor().worn()) {
    if (!renew(at, report)) {
      report.message = "the matrix of the step could not be factorized";
      return false;
    }
    fresh = true;
    trial.preconditioned.resize(0);
  }
  const auto preconditioner = [this](const Eigen::VectorXd& r) { return system.precondition(r); };
  while (true) {
    if (trial.preconditioned.size() == 0) {
      if (!fresh) system.follow(trial.u);
      trial.preconditioned = system.precondition(trial.residual);
    }
    const auto jacobian = [&](const Eigen::VectorXd& w) { return system.product(at, w); };
    const auto linear = detail::minimal_residual(jacobian,
                                                 preconditioner,
                                                 trial.residual,
                                                 trial.preconditioned,
                                                 forcing,
                                                 kMaxLinearIterations);
    report.linear_iterations += linear.iterations;
    linear_reduction = linear.relative_residual;
    const bool sound = linear.finite && linear.iterations > 0;
    if (sound && (linear.converged || fresh) &&
        go_along(equation, at, -linear.x, goal, trial, report))
      return true;
    if (fresh || !linear.finite) {  // u + v / gamma is too far ahead, perhaps inside out
      if (at.differences) {
        report.message = "no step lowered the residual force";
        return false;
      }
      at.differences = true;
      continue;
    }
    if (!renew(at, report)) {
      report.message = "the matrix of the step could not be factorized";
      return false;
    }
    fresh = true;
    trial.preconditioned.resize(0);
  }
}

Eigen::VectorXd StepNewton::Impl::linear_step(const StepEquation& equation,
                                              double accuracy,
                                              Trial& trial,
                                              StepReport& report) {
  const DampedBody::Linearization at = linearize(equation, trial);
  const auto jacobian = [&](const Eigen::VectorXd& w) { return system.product(at, w); };
  const auto preconditioner = [this](const Eigen::VectorXd& r) { return system.precondition(r); };
  bool fresh = !system.factor().fits(at) || system.factor().worn();
  for (;;) {
    if (fresh && !renew(at, report)) {
      report.message = "the matrix of the step could not be factorized";
      return {};
    }
    if (!fresh) system.follow(trial.u);
    const auto linear = detail::minimal_residual(jacobian,
                                                 preconditioner,
                                                 trial.residual,
                                                 system.precondition(trial.residual),
                                                 accuracy,
                                                 kMaxLinearIterations);
    report.linear_iterations += linear.iterations;
    if (linear.converged && linear.finite) return -linear.x;
    if (fresh) {
      report.message = "the linear equations of the step could not be solved";
      return {};
    }
    fresh = true;
  }
}

StepNewton::StepNewton(const ElasticBody& body,
                       const std::vector<int>& held_nodes,
                       NewtonOptions options)
    : m_impl(std::make_unique<Impl>(body, held_nodes, options)) {}
StepNewton::~StepNewton() = default;
StepNewton::StepNewton(StepNewton&&) noexcept = default;
StepNewton& StepNewton::operator=(StepNewton&&) noexcept = default;

void StepNewton::hold(Eigen::MatrixXd C) { m_impl->system.hold(std::move(C)); }

Eigen::VectorXd StepNewton::mass_product(const Eigen::VectorXd& w) const {
  return m_impl->system.damped().mass_product(w);
}

Eigen::VectorXd StepNewton::resisting_force(const Eigen::VectorXd& u,
                                            const Eigen::VectorXd& v) const {
  return m_impl->system.damped().resisting_force(u, v);
}

Eigen::VectorXd StepNewton::damping_force(const Eigen::VectorXd& u,
                                          const Eigen::VectorXd& v) const {
  return m_impl->system.damped().damping_force(u, v);
}

StepSolution StepNewton::solve(const StepEquation& equation,
                               const std::vector<Eigen::VectorXd>& guesses) {
  Impl& impl = *m_impl;
  StepSolution solution;
  StepReport& report = solution.report;
  impl.system.phases = {};
  report.termination = Termination::NumericalFailure;
  Impl::Trial trial = impl.best_of(equation, guesses);
  if (!trial.finite()) {
    report.message = "elements are inside out, or the state or the load is not finite";
    report.residual = kInfinity;
    return solution;
  }
  double scale = kScaleMemory * impl.force_scale;
  double forcing = kFirstForcing;
  for (;; ++report.newton_iterations) {
    scale = std::max(scale, trial.scale);
    const double round_off = kRoundOff * impl.system.factor().diagonal_force(trial.u, trial.delta);
    const double goal = std::max(impl.options.tolerance * scale, round_off);
    report.residual = scale > 0.0 ? trial.norm / scale : 0.0;
    if (trial.norm <= goal) {
      report.termination = Termination::Converged;
      break;
    }
    if (report.newton_iterations == impl.options.max_iterations) {
      report.termination = Termination::IterationLimit;
      report.message = fmt::format(
          "the residual force is still {:.2g} of the forces after {} "
          "Newton iterations",
          report.residual,
          report.newton_iterations);
      break;
    }
    const double before = trial.norm;
    const double accuracy = std::max(forcing, kForcingMargin * goal / trial.norm);
    if (!impl.iterate(equation, std::min(accuracy, kLargestForcing), goal, trial, report)) break;
    // What the linear model did not foresee tells how far it may be trusted next time.
    const double surprise = std::abs(trial.norm / before - impl.linear_reduction);
    forcing = std::clamp(surprise, 1e-6, kLargestForcing);
  }
  impl.system.factor().count_step(report.linear_iterations);
  report.phases = impl.system.phases;
  if (report.termination != Termination::Converged) {
    if (impl.system.damped().stiff_in_volume())
      report.message +=
          " (with a Poisson's ratio so near 1/2, K of a strongly bent body is indefinite and "
          "damping "
          "by b K feeds it; a lower ratio or b = 0 may do)";
    return solution;
  }
  impl.force_scale = scale;
  solution.delta = std::move(trial.delta);
  solution.resisting_force = std::move(trial.resisting);
  return solution;
}

StepSolution StepNewton::solve_linearized(const StepEquation& equation,
                                          const Eigen::VectorXd& guess) {
  Impl& impl = *m_impl;
  StepSolution solution;
  StepReport& report = solution.report;
  impl.system.phases = {};
  report.termination = Termination::NumericalFailure;
  Impl::Trial trial = impl.evaluate(equation, guess);
  if (!trial.finite()) {
    report.message = "elements are inside out where the step is linearized";
    report.residual = kInfinity;
    return solution;
  }
  const double scale = std::max(trial.scale, kScaleMemory * impl.force_scale);
  const double goal = impl.options.tolerance * scale;
  if (trial.norm > goal) {
    report.newton_iterations = 1;
    const Eigen::VectorXd step = impl.linear_step(equation, goal / trial.norm, trial, report);
    if (step.size() == 0) return solution;
    trial = impl.evaluate(equation, trial.delta + step);
    if (!trial.finite()) {
      report.message = "the linearized step turns elements inside out";
      return solution;
    }
  }
  report.residual = trial.norm / scale;
  impl.force_scale = scale;
  impl.system.factor().count_step(report.linear_iterations);
  report.phases = impl.system.phases;
  report.termination = Termination::Converged;
  solution.delta = std::move(trial.delta);
  solution.resisting_force = std::move(trial.resisting);
  return solution;
}

std::string StepNewton::solver() const { return m_impl->system.factor().description(); }

void StepNewton::save(detail::StateWriter& writer) const {
  writer.write(m_impl->force_scale);
  m_impl->system.factor().save(writer);
}

void StepNewton::restore(detail::StateReader& reader) {
  m_impl->force_scale = reader.read_number();
  m_impl->system.factor().restore(reader);
}

}  // namespace twang
