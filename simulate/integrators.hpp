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
#include <string_view>
#include <vector>

namespace twang {

/// Displacement and velocity of a body, (3 num_nodes) each.
struct BodyState {
  Eigen::VectorXd u;    ///< [m]
  Eigen::VectorXd v;    ///< [m/s]
  double time_s = 0.0;  ///< [s]
};

/// A point that is moved along a direction, and free across it.
struct HeldPoint {
  MeshPoint point;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< its length plays no role
};

/// How a step goes from t0 to t1 = t0 + h; F = f_ext - f_int(u) - D(u) v, D(u) = a M + b K(u).
///
///     Newmark                   trapezoidal [paper, eqs. (1)-(3)]:
///                                 M (v1 - v0) = h/2 (F0 + F1),  u1 - u0 = h/2 (v0 + v1)
///     ImplicitEuler               M (v1 - v0) = h F1,           u1 - u0 = h v1
///     Bdf2                        M a1 = F1 with v1 and a1 the derivatives of the parabola through
///                                 the last three u and v; its first step is Newmark's
///     LinearlyImplicitNewmark   Newmark with F1 linearized at u0 + h v0, v0
enum class Scheme { Newmark, ImplicitEuler, Bdf2, LinearlyImplicitNewmark };

/// The name a scene file uses: "newmark", "implicit_euler", "bdf2", "linearly_implicit_newmark".
[[nodiscard]] std::string_view to_string(Scheme scheme);
/// @throws InputError for any other name
[[nodiscard]] Scheme scheme_from(std::string_view name);

struct IntegratorOptions {
  double step_s = 1e-4;  ///< h > 0 [s]
  double tolerance =
      1e-8;  ///< of the residual force, relative to the inertia and elastic forces met [-]
  int max_newton_iterations = 30;
  Scheme scheme = Scheme::Newmark;
  int max_halvings = 6;  ///< of a step that does not converge
  /// Of the preconditioner: which kind, up to which size. Multigrid cycles are the cheaper ones
  /// from some 40,000 unknowns on, long before a factor is too large.
  StiffnessSolverOptions solver = {.max_factor_bytes = 1.5e8};
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// Steps a damped elastic body through time, Newton with a line search; keeps its factor between
/// steps and uses the stale one as preconditioner.
///
/// Newton starts from the last increments' extrapolation if `state` is what the last step returned.
/// A step that does not converge is taken in two halves, these in halves again, as often as the
/// options allow; what cannot be stepped at all leaves the state as it was, with a sentence.
class Integrator {
 public:
  /// Keeps a reference to `body`; weights added to it later do not count.
  /// @param external_force  dead load (3 num_nodes) [N]; empty: none
  /// @throws InputError if sizes disagree, a held node does not exist, or the body's materials
  /// differ in a
  Integrator(const ElasticBody& body,
             std::vector<int> held_nodes,
             IntegratorOptions options,
             Eigen::VectorXd external_force = {});
  ~Integrator();
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  [[nodiscard]] const IntegratorOptions& options() const;
  /// Replaces the dead load from the next step on; empty: none.
  void set_external_force(Eigen::VectorXd external_force);
  /// The held nodes' velocity at the end of the next step, to which they are brought in this one;
  /// at rest until this is called [m/s].
  void set_base_velocity(const Eigen::Vector3d& velocity_m_s);

  /// Holds points from the next step on, in place of those held before; none: they are free. Each
  /// stays where it is along its direction until `set_point_velocities` moves it.
  /// @throws InputError if a point lies among held nodes, or the others hold it already
  void hold_points(const std::vector<HeldPoint>& points);
  /// The held points' velocities along their directions at the end of the next step, to which they
  /// are brought in this one [m/s].
  /// @throws InputError unless there is one for each
  void set_point_velocities(const Eigen::VectorXd& velocities_m_s);

  /// Advances `state` by one step; on failure it is left as it was.
  /// @throws InputError if its sizes disagree with the body or a held node does not move as the
  /// base
  StepReport step(BodyState& state);

  /// How linear equations are solved, in a few words.
  [[nodiscard]] std::string solver() const;

  /// What is carried from step to step beside the state and the held points, so that another
  /// integrator of the same body and options goes on bit by bit as this one would.
  void save(detail::StateWriter& writer) const;
  /// @throws InputError if what is read does not belong to this body
  void restore(detail::StateReader& reader);

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

using NewmarkOptions = IntegratorOptions;
using NewmarkIntegrator = Integrator;

/// Totals of a run.
struct RunSummary {
  int steps = 0;
  long newton_iterations = 0;
  long linear_iterations = 0;
  long factorizations = 0;
  double wall_s = 0.0;
  Termination termination = Termination::NotRun;
  std::string message;  ///< one sentence for a person
  StepPhases phases;
  long halved_steps = 0;
  [[nodiscard]] bool usable() const { return termination == Termination::Converged; }
  /// Counts one step's cost.
  void add(const StepReport& report);
};

/// Steps `state` for `duration_s` (rounded up to whole steps), calling `observe` at the start and
/// after every step; stops at the first step that fails, with the last good state.
/// @param step_s  that of the integrator
/// @throws InputError if step_s is another, or duration_s < 0
/// @throws Cancelled
RunSummary run(Integrator& integrator,
               BodyState& state,
               double step_s,
               double duration_s,
               const std::function<void(const BodyState&)>& observe,
               const ProgressCallback& progress = {});

/// How many steps cover `duration_s`, the last one perhaps not wholly needed.
/// @throws InputError if duration_s < 0 or there would be 2e9 or more
[[nodiscard]] int count_steps(double duration_s, double step_s);

}  // namespace twang
