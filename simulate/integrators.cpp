// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/integrators.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "fem/static_solve.hpp"
#include "simulate/detail/damped_body.hpp"
#include "simulate/detail/state_stream.hpp"
#include "simulate/detail/step_schemes.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

namespace twang {
namespace {

constexpr std::array<std::string_view, 4> kSchemeNames = {
    "newmark", "implicit_euler", "bdf2", "linearly_implicit_newmark"};

void check_load(const ElasticBody& body, const Eigen::VectorXd& force) {
  if (force.size() != 0 && (force.size() != body.mesh().num_dofs() || !force.allFinite()))
    throw InputError(
        fmt::format("external_force has {} entries, must have {} finite ones (or none)",
                    force.size(),
                    body.mesh().num_dofs()));
}

}  // namespace

std::string_view to_string(Scheme scheme) { return kSchemeNames[static_cast<std::size_t>(scheme)]; }

Scheme scheme_from(std::string_view name) {
  for (std::size_t i = 0; i < kSchemeNames.size(); ++i)
    if (kSchemeNames[i] == name) return static_cast<Scheme>(i);
  throw InputError(
      fmt::format("integrator is \"{}\", must be newmark, implicit_euler, bdf2 or "
                  "linearly_implicit_newmark",
                  name));
}

void IntegratorOptions::check() const {
  if (!(step_s > 0.0 && std::isfinite(step_s)))
    throw InputError(fmt::format("step_s is {}, must be > 0", step_s));
  if (!(tolerance > 0.0 && tolerance < 1.0))
    throw InputError(fmt::format("tolerance is {}, must lie between 0 and 1", tolerance));
  if (max_newton_iterations < 1)
    throw InputError(
        fmt::format("max_newton_iterations is {}, must be >= 1", max_newton_iterations));
  constexpr int kMostHalvings = 30;  // a billionth of a step
  if (max_halvings < 0 || max_halvings > kMostHalvings)
    throw InputError(fmt::format("max_halvings is {}, must be 0 to {}", max_halvings, 30));
}

struct Integrator::Impl {
  Impl(const ElasticBody& the_body,
       std::vector<int> held,
       const IntegratorOptions& the_options,
       Eigen::VectorXd force)
      : body(the_body),
        held_nodes(std::move(held)),
        options(the_options),
        external_force(std::move(force)),
        newton(
            body, held_nodes, {options.tolerance, options.max_newton_iterations, options.solver}) {
    complete_load();
  }

  void complete_load() {
    if (external_force.size() == 0) external_force = Eigen::VectorXd::Zero(body.mesh().num_dofs());
    free_force = external_force;
    for (const int node : held_nodes) free_force.segment<3>(3 * node).setZero();
  }

  void check(const BodyState& state) const;
  /// Velocities at the end of a step, of what is not free.
  struct Ends {
    Eigen::Vector3d base;    // of the held nodes [m/s]
    Eigen::VectorXd points;  // of the held points [m/s]
  };
  StepReport advance(BodyState& state, double h, const Ends& ends, int halvings);
  StepReport take(BodyState& state, double h, const Ends& ends);
  void constrain(const StepEquation& equation, const Ends& ends, Eigen::VectorXd& guess) const;
  [[nodiscard]] StepWork work_of(const BodyState& before,
                                 const BodyState& after,
                                 const Eigen::VectorXd& damping_force_after,
                                 double h) const;

  const ElasticBody& body;
  const std::vector<int> held_nodes;
  const IntegratorOptions options;
  Eigen::VectorXd external_force;
  Eigen::VectorXd free_force;  // external_force, 0 at held nodes
  StepNewton newton;
  BodyState last;                        // as the last step returned it
  Eigen::VectorXd last_resisting_force;  // there [N]
  Eigen::VectorXd last_damping_force;    // there, held nodes included [N]
  detail::StepHistory history;
  Ends now = {Eigen::Vector3d::Zero(), {}};   // at the state's time
  Ends next = {Eigen::Vector3d::Zero(), {}};  // a step later
  Eigen::MatrixXd points;                     // c of each held point, held nodes included
  Eigen::MatrixXd free_points;                // held nodes left out
  Eigen::LLT<Eigen::MatrixXd> gram;           // free_pointsᵀ free_points
};

void Integrator::Impl::check(const BodyState& state) const {
  const Eigen::Index dofs = body.mesh().num_dofs();
  if (state.u.size() != dofs || state.v.size() != dofs)
    throw InputError(fmt::format("the state has {} displacements and {} velocities, must have {}",
                                 state.u.size(),
                                 state.v.size(),
                                 dofs));
  for (const int node : held_nodes)
    if (state.v.segment<3>(3 * node) != now.base)
      throw InputError(fmt::format("held node {} moves at {} m/s, must {}",
                                   node,
                                   state.v.segment<3>(3 * node).norm(),
                                   now.base.isZero(0.0)
                                       ? std::string("be at rest")
                                       : fmt::format("move at {} m/s", now.base.norm())));
}

/// Work over a step. With Δu = (u1 - u0):
///
///     load     Δu . f_ext
///     damping  Δu . (D0 v0 + D1 v1) / 2,  or Δu . D1 v1
///     base     Δu . (M (v1 - v0) / h + what resists, weighed likewise, - f_ext), held nodes alone
///     points   c . Δu times what the same force is along c, held points alone
///
/// With these the trapezoidal rule's balance of a linear body's energy is exact.
StepWork Integrator::Impl::work_of(const BodyState& before,
                                   const BodyState& after,
                                   const Eigen::VectorXd& damping_force_after,
                                   double h) const {
  const Eigen::VectorXd du = after.u - before.u;
  const double start_weight = detail::weighs_end_alone(options.scheme) ? 0.0 : 0.5;
  const Eigen::VectorXd damping =
      start_weight * last_damping_force + (1.0 - start_weight) * damping_force_after;
  StepWork work;
  work.load_j = du.dot(external_force);
  work.damping_j = du.dot(damping);
  bool base_moves = false;
  for (const int node : held_nodes)
    base_moves = base_moves || du.segment<3>(3 * node) != Eigen::Vector3d::Zero();
  const bool points_move = !now.points.isZero(0.0) || !next.points.isZero(0.0);
  if (!base_moves && !points_move) return work;
  const Eigen::VectorXd balance =
      body.mass() * (after.v - before.v) / h + start_weight * body.internal_force(before.u) +
      (1.0 - start_weight) * body.internal_force(after.u) + damping - external_force;
  for (const int node : held_nodes)
    work.base_j += du.segment<3>(3 * node).dot(balance.segment<3>(3 * node));
  if (points_move)
    work.points_j = (points.transpose() * du).dot(gram.solve(free_points.transpose() * balance));
  return work;
}

/// Brings what is not free in an increment to where it must be at the end of the step.
void Integrator::Impl::constrain(const StepEquation& equation,
                                 const Ends& ends,
                                 Eigen::VectorXd& guess) const {
  for (const int node : held_nodes)
    guess.segment<3>(3 * node) =
        (ends.base - equation.v_offset.segment<3>(3 * node)) / equation.gamma_per_s;
  if (points.cols() == 0) return;
  const Eigen::VectorXd moved =
      (ends.points - points.transpose() * equation.v_offset) / equation.gamma_per_s;
  guess += free_points * gram.solve(moved - points.transpose() * guess);
}

StepReport Integrator::Impl::take(BodyState& state, double h, const Ends& ends) {
  const bool continued = last.u.size() != 0 && state.u == last.u && state.v == last.v;
  if (!continued) {
    history = {};
    last_resisting_force = newton.resisting_force(state.u, state.v);
    last_damping_force = newton.damping_force(state.u, state.v);
  }
  const StepEquation equation =
      detail::step_equation(options.scheme, h, state, history, free_force, last_resisting_force);
  const bool linearized = options.scheme == Scheme::LinearlyImplicitNewmark;
  auto guesses = linearized ? std::vector<Eigen::VectorXd>{h * state.v}
                            : detail::guess_increments(state, history, h);
  for (Eigen::VectorXd& guess : guesses) constrain(equation, ends, guess);
  StepSolution solution = linearized ? newton.solve_linearized(equation, guesses.front())
                                     : newton.solve(equation, guesses);
  StepReport& report = solution.report;
  if (report.termination != Termination::Converged) return report;

  BodyState end;
  end.u = state.u + solution.delta;
  end.v = equation.gamma_per_s * solution.delta + equation.v_offset;
  for (const int node : held_nodes) end.v.segment<3>(3 * node) = ends.base;
  end.time_s = state.time_s + h;
  Eigen::VectorXd damping_force = newton.damping_force(end.u, end.v);
  report.work = work_of(state, end, damping_force, h);
  detail::remember(history, std::move(solution.delta), end.v - state.v, h);
  last_resisting_force = std::move(solution.resisting_force);
  last_damping_force = std::move(damping_force);
  last = end;
  now = ends;
  state = std::move(end);
  return report;
}

StepReport Integrator::Impl::advance(BodyState& state, double h, const Ends& ends, int halvings) {
  StepReport report = take(state, h, ends);
  if (report.termination == Termination::Converged || halvings == 0) return report;
  const Ends middle = {0.5 * (now.base + ends.base), 0.5 * (now.points + ends.points)};
  report.substeps = 0;
  for (const Ends* end : {&middle, &ends}) {
    const StepReport half = advance(state, 0.5 * h, *end, halvings - 1);
    report.newton_iterations += half.newton_iterations;
    report.linear_iterations += half.linear_iterations;
    report.factorizations += half.factorizations;
    report.substeps += half.substeps;
    report.residual = half.residual;
    report.phases += half.phases;
    report.work += half.work;
    report.termination = half.termination;
    report.message = half.message;
    if (half.termination != Termination::Converged) break;
  }
  return report;
}

Integrator::Integrator(const ElasticBody& body,
                       std::vector<int> held_nodes,
                       IntegratorOptions options,
                       Eigen::VectorXd external_force) {
  options.check();
  check_load(body, external_force);
  m_impl = std::make_unique<Impl>(body, std::move(held_nodes), options, std::move(external_force));
}
Integrator::~Integrator() = default;

const IntegratorOptions& Integrator::options() const { return m_impl->options; }

void Integrator::set_external_force(Eigen::VectorXd external_force) {
  check_load(m_impl->body, external_force);
  m_impl->external_force = std::move(external_force);
  m_impl->complete_load();
}

void Integrator::set_base_velocity(const Eigen::Vector3d& velocity_m_s) {
  m_impl->next.base = velocity_m_s;
}

void Integrator::hold_points(const std::vector<HeldPoint>& points) {
  Impl& impl = *m_impl;
  const auto count = static_cast<Eigen::Index>(points.size());
  impl.points.resize(impl.body.mesh().num_dofs(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const HeldPoint& held = points[static_cast<std::size_t>(i)];
    impl.points.col(i) = nodal_force(impl.body.mesh(), held.point, held.direction.normalized());
  }
  impl.free_points = impl.points;
  for (const int node : impl.held_nodes) impl.free_points.middleRows<3>(3 * node).setZero();
  check_pulls(impl.free_points);
  impl.gram.compute(impl.free_points.transpose() * impl.free_points);
  impl.now.points = impl.next.points = Eigen::VectorXd::Zero(count);
  impl.newton.hold(impl.free_points);
}

void Integrator::set_point_velocities(const Eigen::VectorXd& velocities_m_s) {
  if (velocities_m_s.size() != m_impl->points.cols() || !velocities_m_s.allFinite())
    throw InputError(
        fmt::format("velocities_m_s has {} entries, must have a finite one for each of "
                    "{} held points",
                    velocities_m_s.size(),
                    m_impl->points.cols()));
  m_impl->next.points = velocities_m_s;
}

StepReport Integrator::step(BodyState& state) {
  Impl& impl = *m_impl;
  impl.check(state);
  const BodyState before = state;
  const Impl::Ends ends_before = impl.now;
  StepReport report =
      impl.advance(state, impl.options.step_s, impl.next, impl.options.max_halvings);
  if (report.termination == Termination::Converged) {
    state.time_s = before.time_s + impl.options.step_s;
    return report;
  }
  state = before;
  impl.now = ends_before;
  return report;
}

std::string Integrator::solver() const { return m_impl->newton.solver(); }

void Integrator::save(detail::StateWriter& writer) const {
  const Impl& impl = *m_impl;
  impl.newton.save(writer);
  writer.write(impl.external_force);
  writer.write_flag(impl.last.u.size() != 0);
  if (impl.last.u.size() == 0) return;
  writer.write(impl.last.u);
  writer.write(impl.last.v);
  writer.write(impl.last_resisting_force);
  writer.write(impl.last_damping_force);
  writer.write(Eigen::VectorXd(impl.now.base));
  writer.write(Eigen::VectorXd(impl.next.base));
  writer.write(impl.now.points);
  writer.write(impl.history.step_s);
  writer.write_flag(impl.history.velocity_increment.size() != 0);
  if (impl.history.velocity_increment.size() != 0) writer.write(impl.history.velocity_increment);
  writer.write_count(static_cast<std::int64_t>(impl.history.increments.size()));
  for (const Eigen::VectorXd& increment : impl.history.increments) writer.write(increment);
}

void Integrator::restore(detail::StateReader& reader) {
  Impl& impl = *m_impl;
  const Eigen::Index dofs = impl.body.mesh().num_dofs();
  impl.newton.restore(reader);
  set_external_force(reader.read_vector(dofs));
  impl.last = {};
  impl.history = {};
  if (!reader.read_flag()) return;
  impl.last.u = reader.read_vector(dofs);
  impl.last.v = reader.read_vector(dofs);
  impl.last_resisting_force = reader.read_vector(dofs);
  impl.last_damping_force = reader.read_vector(dofs);
  impl.now.base = reader.read_vector(3);
  impl.next.base = reader.read_vector(3);
  impl.now.points = reader.read_vector(impl.points.cols());
  impl.history.step_s = reader.read_number();
  if (reader.read_flag()) impl.history.velocity_increment = reader.read_vector(dofs);
  const std::int64_t count = reader.read_count();
  for (std::int64_t i = 0; i < count; ++i)
    impl.history.increments.push_back(reader.read_vector(dofs));
}

}  // namespace twang
