// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/static_solve.hpp"

#include "core/error.hpp"
#include "fem/detail/first_lambda.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <utility>

namespace twang {
namespace {

constexpr double kSmallestLoadStep = 1.0 / 4096.0;     // of the whole load [-]
constexpr double kSufficientDecrease = 1e-4;           // Armijo's constant [-]
constexpr double kSmallestStepLength = 1.0 / 16384.0;  // of the Newton step [-]
constexpr double kGapTolerance = 1e-12;  // of the prescribed displacement, relative to it [-]
constexpr double kLargestShift = 1e12;   // of the mass, over the first eigenvalue's estimate [-]
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kRoundOff = 8.0 * kEpsilon;  // of a sum over the elements at a node [-]

/// Nodal forces and prescribed displacement at some part of the load, free degrees of freedom only.
struct LoadStep {
  Eigen::VectorXd force;      // [N]
  Eigen::VectorXd distances;  // that Cᵀ u must have [m]
};

/// What Newton knows at a displacement.
struct Balance {
  Eigen::VectorXd unbalanced;   // internal minus applied force and that of the pulls, free [N]
  Eigen::VectorXd multipliers;  // forces along the pulls [N]
  double residual = 0.0;        // its norm [N]
  double scale = 0.0;           // largest force [N]
  Eigen::VectorXd gaps;         // prescribed minus present displacements of the points [m]
  double size = 0.0;            // largest displacement [m]
  [[nodiscard]] bool finite() const { return std::isfinite(residual); }
};

enum class NewtonEnd { Balanced, TooManyIterations, NotSolved, NoDescent, TurnedInsideOut };

const char* reason(NewtonEnd end) {
  switch (end) {
    case NewtonEnd::Balanced:
      return "balanced";
    case NewtonEnd::TooManyIterations:
      return "Newton's iteration did not converge";
    case NewtonEnd::NotSolved:
      return "the linear systems could not be solved";
    case NewtonEnd::NoDescent:
      return "no step lowered the energy";
    case NewtonEnd::TurnedInsideOut:
      return "elements turned inside out";
  }
  return "";
}

class StaticNewton {
 public:
  StaticNewton(const ElasticBody& body,
               const FreeDofs& free,
               Eigen::MatrixXd constraints,
               const StaticOptions& options)
      : m_body(body),
        m_free(free),
        m_constraints(std::move(constraints)),
        m_gram(m_constraints.transpose() * m_constraints),
        m_options(options),
        m_solver(make_stiffness_solver(body, free, options.solver)),
        m_signs(free.size()) {
    std::mt19937 generator(1);
    for (double& sign : m_signs) sign = (generator() & 1U) != 0U ? 1.0 : -1.0;
  }

  /// Balances `u` under `load`; leaves `u` wherever it ends.
  NewtonEnd balance(const LoadStep& load, double fraction, Eigen::VectorXd& u) {
    Balance state = evaluate(load, u);
    for (int i = 0; i < m_options.max_newton_iterations; ++i) {
      if (!state.finite()) return NewtonEnd::TurnedInsideOut;
      m_round_off = kRoundOff * force_of_unrelated(u);
      if (balanced(state, load)) return NewtonEnd::Balanced;
      report_progress(m_options.progress, {"loading", fraction, 1.0});
      ++m_iterations;
      Eigen::VectorXd p;
      if (!newton_step(u, state, p)) return NewtonEnd::NotSolved;
      const NewtonEnd end = move(load, p, u, state);
      if (end != NewtonEnd::Balanced) return end;
    }
    return balanced(state, load) ? NewtonEnd::Balanced : NewtonEnd::TooManyIterations;
  }

  [[nodiscard]] Balance evaluate(const LoadStep& load, const Eigen::VectorXd& u) {
    const Eigen::VectorXd internal = m_body.internal_force(u);
    Balance state;
    state.unbalanced = m_free.restrict_vector(internal) - load.force;
    if (pulled()) {
      state.multipliers = m_gram.solve(m_constraints.transpose() * state.unbalanced);
      state.unbalanced -= m_constraints * state.multipliers;
      state.gaps = load.distances - m_constraints.transpose() * m_free.restrict_vector(u);
    }
    state.size = u.lpNorm<Eigen::Infinity>();
    state.residual = state.unbalanced.norm();
    if (state.finite()) m_scale = std::max({m_scale, internal.norm(), load.force.norm()});
    state.scale = m_scale;
    return state;
  }

  /// Whether K(u) is positive definite. The last Newton step's matrix answers for the state it led
  /// to; without a step, or where that one was not, it is asked there.
  [[nodiscard]] bool stable(const Eigen::VectorXd& u) {
    const bool linear = m_body.model() == ConstitutiveModel::Linear;
    if (linear || pulled() || m_last_shift == 0.0) return true;
    SolveStatus status = m_solver->prepare({}, u);
    if (status == SolveStatus::Ok && m_solver->kind() == StiffnessSolverKind::Multigrid) {
      Eigen::MatrixXd X;  // conjugate gradients meet a negative curvature where there is one
      status = m_solver->solve(m_signs, X).status;
    }
    return status != SolveStatus::NotPositiveDefinite;
  }

  [[nodiscard]] int iterations() const { return m_iterations; }
  [[nodiscard]] int linear_iterations() const { return m_linear_iterations; }
  [[nodiscard]] std::string solver() const { return m_solver->description(); }

 private:
  [[nodiscard]] bool pulled() const { return m_constraints.size() > 0; }

  [[nodiscard]] bool closed(const Balance& state, const LoadStep& load) const {
    return ((load.distances.cwiseAbs().array() + state.size) * kGapTolerance >=
            state.gaps.cwiseAbs().array())
        .all();
  }

  [[nodiscard]] bool balanced(const Balance& state, const LoadStep& load) const {
    return closed(state, load) &&
           state.residual <= std::max(m_options.tolerance * state.scale, m_round_off);
  }

  /// Norm of the forces that displacements as large as those of u, but each of its own sign, would
  /// need: what cancels at a node, and so leaves its round-off there [N].
  [[nodiscard]] double force_of_unrelated(const Eigen::VectorXd& u) const {
    const Eigen::VectorXd w = m_free.restrict_vector(u).cwiseProduct(m_signs);
    return m_free.restrict_vector(m_body.stiffness_product(u, m_free.expand_vector(w))).norm();
  }

  /// Sets the Newton step `p`, of K with as much of the mass added as makes it positive definite.
  bool newton_step(const Eigen::VectorXd& u, const Balance& state, Eigen::VectorXd& p) {
    const Eigen::Index pulls = m_constraints.cols();
    Eigen::MatrixXd B(m_free.size(), 1 + pulls);
    // Without the pulls' own forces, which change nothing: a solver's error is a part of this.
    B.col(0) = state.unbalanced;
    B.rightCols(pulls) = m_constraints;
    Eigen::MatrixXd X;
    if (!solve_definite(u, B, X) || !X.allFinite()) return false;
    p = -X.col(0);
    if (!pulled()) return true;
    const Eigen::LLT<Eigen::MatrixXd> schur(m_constraints.transpose() * X.rightCols(pulls));
    if (schur.info() != Eigen::Success) return false;
    p += X.rightCols(pulls) * schur.solve(state.gaps - m_constraints.transpose() * p);
    return true;
  }

  bool solve_definite(const Eigen::VectorXd& u, const Eigen::MatrixXd& B, Eigen::MatrixXd& X) {
    double shift = 0.0;
    while (true) {
      SolveStatus status = m_solver->prepare({1.0, 0.0, shift}, u);
      if (status == SolveStatus::Ok) {
        const StiffnessSolution solution = m_solver->solve(B, X);
        m_linear_iterations += solution.iterations;
        status = solution.status;
      }
      // What conjugate gradients have when they are stopped is still a direction of descent.
      m_last_shift = shift;
      if (status == SolveStatus::Ok || status == SolveStatus::NotConverged) return true;
      if (status != SolveStatus::NotPositiveDefinite) return false;
      if (m_first_lambda == 0.0) m_first_lambda = estimate_first_lambda(m_body);
      shift = shift == 0.0 ? m_first_lambda : 10.0 * shift;
      if (shift > kLargestShift * m_first_lambda) return false;
    }
  }

  [[nodiscard]] double potential(const LoadStep& load, const Eigen::VectorXd& u) const {
    return m_body.elastic_energy(u) - load.force.dot(m_free.restrict_vector(u));
  }

  /// Goes along `p`: the whole way while the prescribed displacement is not yet reached, else by a
  /// line search on the potential.
  NewtonEnd move(const LoadStep& load,
                 const Eigen::VectorXd& p,
                 Eigen::VectorXd& u,
                 Balance& state) {
    const Eigen::VectorXd full = m_free.expand_vector(p);
    if (pulled() && !closed(state, load)) {
      u += full;
      state = evaluate(load, u);
      const bool sound = state.finite() && std::isfinite(m_body.elastic_energy(u));
      return sound ? NewtonEnd::Balanced : NewtonEnd::TurnedInsideOut;
    }
    const double start = potential(load, u);
    const double slope = state.unbalanced.dot(p);
    const double blur = 64.0 * kEpsilon * (std::abs(start) + std::abs(load.force.dot(p)));
    for (double step = 1.0; step >= kSmallestStepLength; step *= 0.5) {
      const Eigen::VectorXd trial = u + step * full;
      const double there = potential(load, trial);
      if (!std::isfinite(there)) continue;
      const Balance balance = evaluate(load, trial);
      if (!balance.finite()) continue;
      const bool lower = there <= start + kSufficientDecrease * step * slope;
      // Near the minimum the energy's change drowns in round-off; the residual still tells.
      const bool level = there <= start + blur && balance.residual < state.residual;
      if (lower || level) {
        u = trial;
        state = balance;
        return NewtonEnd::Balanced;
      }
    }
    return NewtonEnd::NoDescent;
  }

  const ElasticBody& m_body;
  const FreeDofs& m_free;
  const Eigen::MatrixXd m_constraints;       // C, free, a column for each pull
  const Eigen::LLT<Eigen::MatrixXd> m_gram;  // Cᵀ C
  const StaticOptions& m_options;
  std::unique_ptr<StiffnessSolver> m_solver;
  Eigen::VectorXd m_signs;      // 1 or -1, of each free degree of freedom
  double m_first_lambda = 0.0;  // about the smallest eigenvalue; 0: not needed yet [1/s²]
  int m_linear_iterations = 0;
  double m_scale = 0.0;                // largest force met [N]
  double m_round_off = 0.0;            // residual that is only round-off [N]
  std::optional<double> m_last_shift;  // of the mass in the last Newton step [1/s²]
  int m_iterations = 0;
};

void check_pull(const Eigen::Vector3d& pull) {
  if (!(pull.norm() > 0.0 && pull.allFinite()))
    throw InputError(fmt::format(
        "load.pull is ({}, {}, {}) m, must have a length > 0", pull.x(), pull.y(), pull.z()));
}

void check_sizes(const ElasticBody& body,
                 const std::vector<int>& held_nodes,
                 const StaticLoad& load,
                 const Eigen::VectorXd& start) {
  const Eigen::Index dofs = body.mesh().num_dofs();
  if (held_nodes.empty())
    throw InputError("held_nodes is empty, static equilibrium needs a body that is held");
  if (load.force.size() != 0 && load.force.size() != dofs)
    throw InputError(
        fmt::format("load.force has {} entries, must have {} (or none)", load.force.size(), dofs));
  if (load.force.size() != 0 && !load.force.allFinite())
    throw InputError("load.force has entries that are not finite, must be numbers");
  if (start.size() != 0 && (start.size() != dofs || !start.allFinite()))
    throw InputError(fmt::format(
        "start has {} entries, must have {} finite ones (or none)", start.size(), dofs));
  if (load.pulled_point) check_pull(load.pull);
  for (const PulledPoint& pulled : load.more_pulls) check_pull(pulled.displacement);
}

/// The points that are pulled, in one list.
std::vector<PulledPoint> all_pulls(const StaticLoad& load) {
  std::vector<PulledPoint> pulls = load.more_pulls;
  if (load.pulled_point) pulls.insert(pulls.begin(), {*load.pulled_point, load.pull});
  return pulls;
}

/// C, of the free degrees of freedom.
Eigen::MatrixXd constraint_matrix(const ElasticBody& body,
                                  const FreeDofs& free,
                                  const std::vector<PulledPoint>& pulls) {
  Eigen::MatrixXd C(free.size(), static_cast<Eigen::Index>(pulls.size()));
  for (Eigen::Index i = 0; i < C.cols(); ++i) {
    const PulledPoint& pull = pulls[static_cast<std::size_t>(i)];
    C.col(i) =
        free.restrict_vector(nodal_force(body.mesh(), pull.point, pull.displacement.normalized()));
  }
  check_pulls(C);
  return C;
}

}  // namespace

void StaticOptions::check() const {
  if (!(tolerance > 0.0 && tolerance < 1.0))
    throw InputError(fmt::format("tolerance is {}, must lie between 0 and 1", tolerance));
  if (max_newton_iterations < 1)
    throw InputError(
        fmt::format("max_newton_iterations is {}, must be >= 1", max_newton_iterations));
  if (load_steps < 1) throw InputError(fmt::format("load_steps is {}, must be >= 1", load_steps));
  solver.check();
}

StaticResult solve_static(const ElasticBody& body,
                          const std::vector<int>& held_nodes,
                          const StaticLoad& load,
                          const StaticOptions& options,
                          const Eigen::VectorXd& start) {
  options.check();
  check_sizes(body, held_nodes, load, start);
  const FreeDofs free(body.mesh().num_nodes(), held_nodes);
  const std::vector<PulledPoint> pulls = all_pulls(load);
  const Eigen::MatrixXd C = constraint_matrix(body, free, pulls);
  const Eigen::VectorXd full_force =
      load.force.size() != 0 ? load.force : Eigen::VectorXd::Zero(body.mesh().num_dofs()).eval();

  StaticResult result;
  result.u = start.size() != 0 ? start : Eigen::VectorXd::Zero(body.mesh().num_dofs()).eval();
  LoadStep first{free.restrict_vector(body.internal_force(result.u)),
                 C.transpose() * free.restrict_vector(result.u)};
  if (!first.force.allFinite()) {
    result.termination = Termination::NumericalFailure;
    result.message =
        "the displacement to start from turns elements inside out, or squeezes them until they "
        "collapse";
    return result;
  }
  LoadStep last{free.restrict_vector(full_force), Eigen::VectorXd(C.cols())};
  for (Eigen::Index i = 0; i < C.cols(); ++i)
    last.distances[i] = pulls[static_cast<std::size_t>(i)].displacement.norm();

  StaticNewton newton(body, free, C, options);
  double done = 0.0;
  double part = 1.0 / options.load_steps;
  NewtonEnd end = NewtonEnd::Balanced;
  while (done < 1.0 && part >= kSmallestLoadStep) {
    const double next = done + part > 1.0 - kSmallestLoadStep ? 1.0 : done + part;
    const LoadStep step{first.force + next * (last.force - first.force),
                        first.distances + next * (last.distances - first.distances)};
    Eigen::VectorXd u = result.u;
    end = newton.balance(step, done, u);
    if (end == NewtonEnd::Balanced) {
      result.u = u;
      done = next;
      ++result.load_steps;
    } else {
      part *= 0.5;
    }
  }
  const Balance state = newton.evaluate(last, result.u);
  result.reaction = body.internal_force(result.u) - full_force;
  result.pull_forces_n.assign(state.multipliers.begin(), state.multipliers.end());
  if (C.cols() > 0) result.pull_force_n = state.multipliers[0];
  result.residual = state.scale > 0.0 ? state.residual / state.scale : 0.0;
  result.load_fraction = done;
  result.newton_iterations = newton.iterations();
  result.linear_iterations = newton.linear_iterations();
  result.solver = newton.solver();
  result.stable = done < 1.0 || newton.stable(result.u);
  result.termination = done == 1.0 ? Termination::Converged : Termination::NumericalFailure;
  result.message =
      done == 1.0
          ? fmt::format("in equilibrium after {} Newton iterations in {} load steps",
                        result.newton_iterations,
                        result.load_steps)
          : fmt::format(
                "no equilibrium found beyond {:.3g} % of the load: {}", 100.0 * done, reason(end));
  if (!result.stable) {
    result.message += fmt::format(
        ", but not a stable one: the stiffness there is not positive definite, so that the part or "
        "its elements buckle at the slightest push{}",
        body.model() == ConstitutiveModel::SaintVenantKirchhoff
            ? "; Saint Venant-Kirchhoff softens under compression, neo-Hookean does not"
            : "");
  }
  return result;
}

}  // namespace twang
