// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/step_schemes.hpp"

#include <algorithm>
#include <utility>

namespace twang::detail {
namespace {

constexpr std::size_t kIncrementsKept = 5;
constexpr std::size_t kLargestOrder = 3;  // higher ones amplify what alternates

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

StepEquation trapezoidal(double h,
                         const BodyState& state,
                         const Eigen::VectorXd& external_force,
                         const Eigen::VectorXd& resisting_force) {
  return {4.0 / (h * h),
          2.0 / h,
          state.u,
          h * state.v,
          -state.v,
          2.0 * external_force - resisting_force};
}

StepEquation implicit_euler(double h,
                            const BodyState& state,
                            const Eigen::VectorXd& external_force) {
  return {1.0 / (h * h),
          1.0 / h,
          state.u,
          h * state.v,
          Eigen::VectorXd::Zero(state.v.size()),
          external_force};
}

/// With r = h / h_before:  h v1 = alpha δ - kappa δ_before,  alpha = (1 + 2 r) / (1 + r),
/// kappa = r² / (1 + r);  h a1 likewise of v.
StepEquation bdf2(double h,
                  const BodyState& state,
                  const StepHistory& history,
                  const Eigen::VectorXd& external_force) {
  const double r = h / history.step_s;
  const double alpha = (1.0 + 2.0 * r) / (1.0 + r);
  const double kappa = r * r / (1.0 + r);
  StepEquation equation;
  equation.mu_per_s2 = alpha * alpha / (h * h);
  equation.gamma_per_s = alpha / h;
  equation.u0 = state.u;
  equation.v_offset = -kappa / h * history.increments.front();
  equation.delta_free = (h / alpha) * (state.v - equation.v_offset) +
                        (kappa * h / (alpha * alpha)) * history.velocity_increment;
  equation.load = external_force;
  return equation;
}

}  // namespace

StepEquation step_equation(Scheme scheme,
                           double step_s,
                           const BodyState& state,
                           const StepHistory& history,
                           const Eigen::VectorXd& external_force,
                           const Eigen::VectorXd& resisting_force) {
  switch (scheme) {
    case Scheme::ImplicitEuler:
      return implicit_euler(step_s, state, external_force);
    case Scheme::Bdf2:
      if (history.velocity_increment.size() != 0)
        return bdf2(step_s, state, history, external_force);
      break;
    case Scheme::Newmark:
    case Scheme::LinearlyImplicitNewmark:
      break;
  }
  return trapezoidal(step_s, state, external_force, resisting_force);
}

bool weighs_end_alone(Scheme scheme) { return scheme == Scheme::ImplicitEuler; }

std::vector<Eigen::VectorXd> guess_increments(const BodyState& state,
                                              const StepHistory& history,
                                              double step_s) {
  const std::size_t count = history.increments.size();
  if (count == 0 || history.step_s != step_s) return {step_s * state.v};
  std::vector<Eigen::VectorXd> candidates = {
      extrapolate(history.increments, std::min(count, kLargestOrder), false)};
  if (count > 1) candidates.push_back(extrapolate(history.increments, count - 1, true));
  return candidates;
}

void remember(StepHistory& history,
              Eigen::VectorXd increment,
              Eigen::VectorXd velocity_increment,
              double step_s) {
  if (history.step_s != step_s) history.increments.clear();
  history.step_s = step_s;
  history.velocity_increment = std::move(velocity_increment);
  history.increments.push_front(std::move(increment));
  if (history.increments.size() > kIncrementsKept) history.increments.pop_back();
}

}  // namespace twang::detail
