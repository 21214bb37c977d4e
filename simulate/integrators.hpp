// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/progress.hpp"
#include "core/termination.hpp"
#include "fem/elastic_body.hpp"
#include "simulate/newton.hpp"

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace twang {

/// Displacement and velocity of a body, (3 num_nodes) each.
struct BodyState {
  Eigen::VectorXd u;    ///< [m]
  Eigen::VectorXd v;    ///< [m/s]
  double time_s = 0.0;  ///< [s]
};

struct NewmarkOptions {
  double step_s = 1e-4;  ///< h > 0 [s]
  double tolerance =
      1e-8;  ///< of the residual force, relative to the inertia and elastic forces met [-]
  int max_newton_iterations = 30;
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// Trapezoidal Newmark of a damped elastic body [paper, eqs. (1)-(3)], Newton with a line search;
/// keeps its factor between steps and uses the stale one as preconditioner.
///
///     M δ = h M v0 + h²/4 (F(u0) + F(u1)) - h²/4 (D(u0) v0 + D(u1) v1)
///     u1 = u0 + δ,   v1 = 2/h δ - v0
///
/// with F = -(internal force) + external force and D = a M + b K(u). Newton starts from the last
/// increments' extrapolation if `state` is what the last step returned.
class NewmarkIntegrator {
 public:
  /// Keeps a reference to `body`; weights added to it later do not count.
  /// @param external_force  dead load (3 num_nodes) [N]; empty: none
  /// @throws InputError if sizes disagree, a held node does not exist, or the body's materials
  /// differ in a
  NewmarkIntegrator(const ElasticBody& body,
                    std::vector<int> held_nodes,
                    NewmarkOptions options,
                    Eigen::VectorXd external_force = {});
  ~NewmarkIntegrator();
  NewmarkIntegrator(const NewmarkIntegrator&) = delete;
  NewmarkIntegrator& operator=(const NewmarkIntegrator&) = delete;

  [[nodiscard]] const NewmarkOptions& options() const;
  /// Replaces the dead load from the next step on; empty: none.
  void set_external_force(Eigen::VectorXd external_force);

  /// Advances `state` by one step; on failure it is left as it was.
  /// @throws InputError if its sizes disagree with the body or a held node moves
  StepReport step(BodyState& state);

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

/// Totals of a run.
struct RunSummary {
  int steps = 0;
  long newton_iterations = 0;
  long linear_iterations = 0;
  long factorizations = 0;
  double wall_s = 0.0;
  Termination termination = Termination::NotRun;
  std::string message;  ///< one sentence for a person
  [[nodiscard]] bool usable() const { return termination == Termination::Converged; }
};

/// Steps `state` for `duration_s` (rounded up to whole steps), calling `observe` at the start and
/// after every step; stops at the first step that fails, with the last good state.
/// @param step_s  that of the integrator
/// @throws InputError if step_s is another, or duration_s < 0
/// @throws Cancelled
RunSummary run(NewmarkIntegrator& integrator,
               BodyState& state,
               double step_s,
               double duration_s,
               const std::function<void(const BodyState&)>& observe,
               const ProgressCallback& progress = {});

}  // namespace twang
