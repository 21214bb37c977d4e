// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "simulate/integrators.hpp"

#include <Eigen/Core>

#include <deque>
#include <vector>

namespace twang::detail {

/// What the last steps leave to the next.
struct StepHistory {
  std::deque<Eigen::VectorXd> increments;  // of u, latest first, all over the same h [m]
  Eigen::VectorXd velocity_increment;      // of the last step; empty: there was none [m/s]
  double step_s = 0.0;                     // of the last step [s]
};

/// A step of one scheme as an equation for the increment of u.
/// @param resisting_force  f_int(u0) + D(u0) v0, 0 at held nodes [N]
[[nodiscard]] StepEquation step_equation(Scheme scheme,
                                         double step_s,
                                         const BodyState& state,
                                         const StepHistory& history,
                                         const Eigen::VectorXd& external_force,
                                         const Eigen::VectorXd& resisting_force);

/// Whether the scheme counts what acts at the end of a step alone, or the mean of start and end.
[[nodiscard]] bool weighs_end_alone(Scheme scheme);

/// Increments that a step may turn out to be, by the last ones; at least one.
[[nodiscard]] std::vector<Eigen::VectorXd> guess_increments(const BodyState& state,
                                                            const StepHistory& history,
                                                            double step_s);

/// The step has been taken.
void remember(StepHistory& history,
              Eigen::VectorXd increment,
              Eigen::VectorXd velocity_increment,
              double step_s);

}  // namespace twang::detail
