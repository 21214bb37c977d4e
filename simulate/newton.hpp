// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/termination.hpp"
#include "fem/elastic_body.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace twang {
namespace detail {
class StateReader;
class StateWriter;
}  // namespace detail

/// One implicit time step of a damped elastic body, as an equation for the displacement increment
/// δ:
///
///     r(δ) = mu M (δ - δ̂) + f_int(u1) + D(u1) v1 - c = 0
///     u1 = u0 + δ,   v1 = gamma δ + v̂,   D(u) = a M + sum of b_e K_e(u)
///
/// Trapezoidal Newmark has mu = 4/h², gamma = 2/h, δ̂ = h v0, v̂ = -v0 and c = 2 f_ext - f_int(u0) -
/// D(u0) v0; implicit Euler mu = 1/h², gamma = 1/h, δ̂ = h v0, v̂ = 0, c = f_ext; static
/// equilibrium mu = gamma = 0, v̂ = 0, c = f_ext. Vectors are (3 num_nodes).
struct StepEquation {
  double mu_per_s2 = 0.0;      ///< mu >= 0 [1/s²]
  double gamma_per_s = 0.0;    ///< gamma >= 0 [1/s]
  Eigen::VectorXd u0;          ///< [m]
  Eigen::VectorXd delta_free;  ///< δ̂, the increment of free motion [m]
  Eigen::VectorXd v_offset;    ///< v̂ [m/s]
  Eigen::VectorXd load;        ///< c [N]
};

/// Wall time by what it was spent on [s].
struct StepPhases {
  double forces_s = 0.0;          ///< internal and damping forces
  double products_s = 0.0;        ///< with the matrix-free Jacobian
  double factorization_s = 0.0;   ///< assembly included
  double preconditioner_s = 0.0;  ///< triangular solves, turned
  StepPhases& operator+=(const StepPhases& other);
};

/// Work over a step, by the integrator's own quadrature [J].
struct StepWork {
  double load_j = 0.0;     ///< of the dead load on the body
  double base_j = 0.0;     ///< of the moving base on the body
  double damping_j = 0.0;  ///< taken out by D
  double points_j = 0.0;   ///< of what moves held points on the body
  StepWork& operator+=(const StepWork& other);
};

/// Why a step stopped, and what it cost.
struct StepReport {
  int newton_iterations = 0;
  int linear_iterations = 0;
  int factorizations = 0;
  double residual = 0.0;  ///< relative, at the end [-]
  Termination termination = Termination::NotRun;
  std::string message;  ///< one sentence for a person if it did not converge
  StepPhases phases;
  StepWork work;     ///< if it converged
  int substeps = 1;  ///< more than one if the step had to be halved
};

struct StepSolution {
  Eigen::VectorXd delta;            ///< [m]
  Eigen::VectorXd resisting_force;  ///< f_int(u1) + D(u1) v1, 0 at held nodes [N]
  StepReport report;
};

struct NewtonOptions {
  double tolerance = 1e-8;  ///< of ‖r‖, relative to the inertia and resisting forces met [-]
  int max_iterations = 30;
  StiffnessSolverOptions solver = {};  ///< of the preconditioner: which kind, up to which size
};

/// Solves step equations of one body by Newton's method.
///
/// Linear systems are solved by MINRES on the matrix-free Jacobian (derivative of D included),
/// preconditioned by the Cholesky factor of an earlier step, turned with the body node by node and
/// renewed when iterations add up to its cost (of large voxel meshes by a multigrid cycle); each
/// only as accurately as Newton's convergence deserves [Eisenstat & Walker 1996]. A line search
/// lowers rᵀ P⁻¹ r, for which every MINRES iterate is a direction of descent, however stiff or
/// indefinite the Jacobian. Residuals below the round-off of the forces count as zero.
class StepNewton {
 public:
  /// Keeps a reference to `body`.
  /// @throws InputError if a held node does not exist or the materials differ in a
  StepNewton(const ElasticBody& body, const std::vector<int>& held_nodes, NewtonOptions options);
  ~StepNewton();
  StepNewton(StepNewton&&) noexcept;
  StepNewton& operator=(StepNewton&&) noexcept;

  /// Holds points along directions, (3 num_nodes x k), a column c each, 0 at held nodes: increments
  /// keep c . δ as the guesses have it, and the residual is free along c. No columns: none.
  void hold(Eigen::MatrixXd C);

  /// M w.
  [[nodiscard]] Eigen::VectorXd mass_product(const Eigen::VectorXd& w) const;
  /// f_int(u) + D(u) v, 0 at held nodes [N].
  [[nodiscard]] Eigen::VectorXd resisting_force(const Eigen::VectorXd& u,
                                                const Eigen::VectorXd& v) const;
  /// D(u) v, held nodes included [N].
  [[nodiscard]] Eigen::VectorXd damping_force(const Eigen::VectorXd& u,
                                              const Eigen::VectorXd& v) const;
  /// @param guesses  increments to start from, the one with the least residual is taken; those of
  /// held nodes stay as they are; at least one
  [[nodiscard]] StepSolution solve(const StepEquation& equation,
                                   const std::vector<Eigen::VectorXd>& guesses);
  /// The equation linearized at `guess` and solved to the tolerance: one step of Newton's, with
  /// neither line search nor a look at what is left over.
  [[nodiscard]] StepSolution solve_linearized(const StepEquation& equation,
                                              const Eigen::VectorXd& guess);

  /// How linear equations are solved, in a few words.
  [[nodiscard]] std::string solver() const;

  /// What is carried from step to step, so that another may go on bit by bit as this one would.
  void save(detail::StateWriter& writer) const;
  /// @throws InputError if what is read does not belong to this body
  void restore(detail::StateReader& reader);

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

}  // namespace twang
