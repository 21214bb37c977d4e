// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/static_newton.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "simulate/detail/damped_body.hpp"
#include "simulate/detail/stale_factor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace twang {
namespace {

constexpr double kSmallestPart = 1.0 / 256.0;        // of the whole load [-]
constexpr double kArmijo = 1e-4;                     // Armijo's constant [-]
constexpr double kSmallestStepPart = 1.0 / 16384.0;  // of the Newton step [-]
constexpr double kForcing = 1e-2;                    // accuracy of a linear solve [-]
constexpr int kMaxTruncatedIterations = 150;
constexpr double kGapTolerance = 1e-12;  // of the prescribed displacement, relative to it [-]
constexpr double kFinest = 1e-9;         // tolerance: inexact steps go no further [-]
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// What is to be balanced, (3 num_nodes), 0 at held nodes.
struct Goal {
  Eigen::VectorXd force;
  double distance = 0.0;  // that c . u must have [m]
};

struct Balance {
  Eigen::VectorXd gradient;  // internal minus applied force [N]
  double multiplier = 0.0;   // force along the pull [N]
  double residual = 0.0;     // [N]
  double gap = 0.0;          // [m]
  double potential = 0.0;    // [J]
  [[nodiscard]] bool sound() const { return std::isfinite(residual) && std::isfinite(potential); }
};

class StaticMinimizer {
 public:
  StaticMinimizer(const ElasticBody& body,
                  const std::vector<int>& held_nodes,
                  Eigen::VectorXd constraint,
                  const StaticOptions& options,
                  const StiffnessSolverOptions& solver)
      : m_body(body),
        m_damped(body, held_nodes),
        m_preconditioner(m_damped, solver),
        m_constraint(std::move(constraint)),
        m_options(options) {}

  /// Balances `u`; a reason if that fails, else empty.
  std::string balance(const Goal& goal, double fraction, Eigen::VectorXd& u) {
    detail::DampedBody::Linearization at;
    at.u = u;
    at.v = Eigen::VectorXd::Zero(u.size());
    if (!m_preconditioner.fits(at) && !m_preconditioner.renew(at))
      return "the stiffness could not be prepared";
    Balance now = evaluate(goal, u);
    for (int i = 0; i <= m_options.max_newton_iterations; ++i) {
      if (!now.sound()) return "elements turned inside out";
      if (balanced(goal, now, u)) return {};
      report_progress(m_options.progress, {"loading", fraction, 1.0});
      ++m_iterations;
      m_preconditioner.follow(u);
      if (pulled()) {
        m_pull_response = m_preconditioner.apply(m_constraint);
        m_pull_response /= m_constraint.dot(m_pull_response);
        if (!closed(goal, now, u)) {
          u += now.gap * m_pull_response;
          now = evaluate(goal, u);
          continue;
        }
      }
      at.u = u;
      const Eigen::VectorXd p = newton_step(at, now);
      if (p.size() == 0) return "the linear equations could not be solved";
      const std::string fault = move(goal, p, u, now);
      if (!fault.empty()) return fault;
    }
    return "Newton's iteration did not converge";
  }

  [[nodiscard]] Balance evaluate(const Goal& goal, const Eigen::VectorXd& u) {
    Balance now;
    const Eigen::VectorXd internal = m_damped.resisting_force(u, Eigen::VectorXd::Zero(u.size()));
    now.gradient = internal - goal.force;
    now.potential = m_body.elastic_energy(u) - goal.force.dot(u);
    Eigen::VectorXd residual = now.gradient;
    if (pulled()) {
      now.multiplier = m_constraint.dot(now.gradient) / m_constraint.squaredNorm();
      residual -= now.multiplier * m_constraint;
      now.gap = goal.distance - m_constraint.dot(u);
    }
    now.residual = residual.norm();
    if (now.sound()) m_scale = std::max({m_scale, internal.norm(), goal.force.norm()});
    return now;
  }

  [[nodiscard]] int iterations() const { return m_iterations; }
  [[nodiscard]] double scale() const { return m_scale; }

 private:
  [[nodiscard]] bool pulled() const { return m_constraint.size() > 0; }

  [[nodiscard]] bool closed(const Goal& goal, const Balance& now, const Eigen::VectorXd& u) const {
    return std::abs(now.gap) <=
           kGapTolerance * (std::abs(goal.distance) + u.lpNorm<Eigen::Infinity>());
  }
  [[nodiscard]] bool balanced(const Goal& goal,
                              const Balance& now,
                              const Eigen::VectorXd& u) const {
    const double round_off =
        8.0 * kEpsilon * m_preconditioner.diagonal_force(u, Eigen::VectorXd::Zero(u.size()));
    const double tolerance = std::max(m_options.tolerance, kFinest);
    return closed(goal, now, u) && now.residual <= std::max(tolerance * m_scale, round_off);
  }

  /// P⁻¹ r, along which the pulled point stays where it is.
  [[nodiscard]] Eigen::VectorXd precondition(const Eigen::VectorXd& r) const {
    if (!pulled()) return m_preconditioner.apply(r);
    // What is along c changes nothing, and would drown the rest: the cycle is in single precision.
    const double along = m_constraint.dot(r) / m_constraint.squaredNorm();
    Eigen::VectorXd z = m_preconditioner.apply(r - along * m_constraint);
    z -= m_pull_response * m_constraint.dot(z);
    return z;
  }

  /// An inexact Newton step that lowers the potential: conjugate gradients, cut short where the
  /// curvature is not positive [Steihaug 1983]. Empty if a product is not finite.
  [[nodiscard]] Eigen::VectorXd newton_step(const detail::DampedBody::Linearization& at,
                                            const Balance& now) const {
    Eigen::VectorXd p = Eigen::VectorXd::Zero(at.u.size());
    Eigen::VectorXd r = -now.gradient;
    Eigen::VectorXd z = precondition(r);
    Eigen::VectorXd d = z;
    double rz = r.dot(z);
    const double goal = kForcing * kForcing * rz;
    for (int i = 0; i < kMaxTruncatedIterations && rz > goal; ++i) {
      const Eigen::VectorXd q = m_damped.step_product(at, d);
      const double curvature = d.dot(q);
      if (!std::isfinite(curvature)) return {};
      if (curvature <= 0.0) return i == 0 ? d : p;
      const double length = rz / curvature;
      p += length * d;
      r -= length * q;
      z = precondition(r);
      const double next = r.dot(z);
      d = z - (length * q.dot(z) / rz) * d;  // flexibly: the cycle rounds
      rz = next;
    }
    return p;
  }

  /// A line search on the potential.
  std::string move(const Goal& goal, const Eigen::VectorXd& p, Eigen::VectorXd& u, Balance& now) {
    const double slope = now.gradient.dot(p);
    const double blur = 64.0 * kEpsilon * (std::abs(now.potential) + std::abs(goal.force.dot(p)));
    for (double step = 1.0; step >= kSmallestStepPart; step *= 0.5) {
      const Eigen::VectorXd trial = u + step * p;
      const Balance there = evaluate(goal, trial);
      if (!there.sound()) continue;
      const bool lower = there.potential <= now.potential + kArmijo * step * slope;
      // Near the minimum the energy's change drowns in round-off; the residual still tells.
      const bool level = there.potential <= now.potential + blur && there.residual < now.residual;
      if (!lower && !level) continue;
      u = trial;
      now = there;
      return {};
    }
    return "no step lowered the energy";
  }

  const ElasticBody& m_body;
  detail::DampedBody m_damped;
  detail::StaleFactor m_preconditioner;
  const Eigen::VectorXd m_constraint;  // c, 0 at held nodes; empty: nothing is pulled
  const StaticOptions& m_options;
  Eigen::VectorXd m_pull_response;  // P⁻¹ c / (c . P⁻¹ c)
  double m_scale = 0.0;             // largest force met [N]
  int m_iterations = 0;
};

void check(const ElasticBody& body,
           const std::vector<int>& held_nodes,
           const StaticLoad& load,
           const StaticOptions& options) {
  options.check();
  if (held_nodes.empty())
    throw InputError("held_nodes is empty, static equilibrium needs a body that is held");
  if (load.force.size() != 0 &&
      (load.force.size() != body.mesh().num_dofs() || !load.force.allFinite()))
    throw InputError(fmt::format("load.force has {} entries, must have {} finite ones (or none)",
                                 load.force.size(),
                                 body.mesh().num_dofs()));
  if (load.pulled_point && !(load.pull.norm() > 0.0 && load.pull.allFinite()))
    throw InputError("load.pull is no vector with a length > 0, must be one");
}

}  // namespace

StaticResult solve_static_matrix_free(const ElasticBody& body,
                                      const std::vector<int>& held_nodes,
                                      const StaticLoad& load,
                                      const StaticOptions& options,
                                      const StiffnessSolverOptions& solver) {
  check(body, held_nodes, load, options);
  const auto at_free = [&](Eigen::VectorXd field) {
    for (const int node : held_nodes) field.segment<3>(3 * node).setZero();
    return field;
  };
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(body.mesh().num_dofs());
  Eigen::VectorXd constraint;
  if (load.pulled_point) {
    constraint = at_free(nodal_force(body.mesh(), *load.pulled_point, load.pull.normalized()));
    if (!(constraint.norm() > 0.0))
      throw InputError("load.pulled_point lies among held nodes, must be free to move");
  }
  const Goal last{at_free(load.force.size() != 0 ? load.force : nothing),
                  load.pulled_point ? load.pull.norm() : 0.0};
  StaticMinimizer minimizer(body, held_nodes, constraint, options, solver);
  StaticResult result;
  result.u = nothing;
  std::string fault;
  double done = 0.0;
  double part = 1.0 / options.load_steps;
  while (done < 1.0 && part >= kSmallestPart) {
    const double next = done + part > 1.0 - kSmallestPart ? 1.0 : done + part;
    Eigen::VectorXd u = result.u;
    fault = minimizer.balance({next * last.force, next * last.distance}, done, u);
    if (fault.empty()) {
      result.u = std::move(u);
      done = next;
      ++result.load_steps;
    } else {
      part *= 0.5;
    }
  }
  const Balance end = minimizer.evaluate(last, result.u);
  result.reaction = body.internal_force(result.u);
  if (load.force.size() != 0) result.reaction -= load.force;
  result.pull_force_n = end.multiplier;
  result.load_fraction = done;
  result.residual = minimizer.scale() > 0.0 ? end.residual / minimizer.scale() : 0.0;
  result.newton_iterations = minimizer.iterations();
  result.termination = done == 1.0 ? Termination::Converged : Termination::NumericalFailure;
  result.message =
      done == 1.0
          ? fmt::format("in equilibrium after {} Newton iterations in {} load steps",
                        result.newton_iterations,
                        result.load_steps)
          : fmt::format(
                "no equilibrium found beyond {:.3g} % of the load: {}", 100.0 * done, fault);
  return result;
}

}  // namespace twang
