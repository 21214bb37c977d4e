// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/linear_solver.hpp"
#include "fem/multigrid_preconditioner.hpp"
#include "fem/stiffness_solver.hpp"
#include "simulate/detail/damped_body.hpp"
#include "simulate/detail/nodal_rotations.hpp"
#include "simulate/detail/state_stream.hpp"

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace twang::detail {

/// The factor of a step matrix, kept as a preconditioner while the body moves on.
///
/// The factor belongs to the shape at which it was made. What spoils it most is that parts of the
/// body turn, so vectors are turned into that shape's frame and back, node by node,
///
///     P⁻¹ = R H⁻¹ Rᵀ,   R = diag(R_i),  R_i the rotation of node i since,
///
/// which is exact for a body that turns as a whole, up to the single precision in which H⁻¹ is
/// applied.
///
/// When to renew it: with F the cost of a factorization in iterations, and each step after it
/// taking some more iterations than the one before, the cost per step is least when the iterations
/// spent beyond those of a fresh factor add up to F.
///
/// Above what a factor can hold, a multigrid cycle of the undeformed body takes its place, which is
/// positive definite whatever becomes of the body, and is never renewed.
class StaleFactor {
 public:
  explicit StaleFactor(const DampedBody& body, const StiffnessSolverOptions& options = {});

  /// Factorizes the step matrix at `at`; if it is not positive definite there, without the
  /// derivative of D, and at last that of the undeformed body.
  /// @return  false if neither can be factorized (out of memory)
  bool renew(const DampedBody::Linearization& at);
  /// Whether there is a factor and its weights of inertia and velocity are those of `at`.
  [[nodiscard]] bool fits(const DampedBody::Linearization& at) const;

  /// Turns the frame to displacement `u`; call before `apply`.
  void follow(const Eigen::VectorXd& u);
  /// P⁻¹ r, (3 num_nodes), 0 at held nodes; not finite if the solve fails.
  [[nodiscard]] Eigen::VectorXd apply(const Eigen::VectorXd& r) const;

  /// Norm of the forces that the factored matrix's diagonal makes of displacement `u` (its
  /// stiffness alone) and increment `delta` (all of it): round-off of a residual is some eps of it;
  /// 0 without a factor [N].
  [[nodiscard]] double diagonal_force(const Eigen::VectorXd& u, const Eigen::VectorXd& delta) const;

  /// Tells how many iterations a step took.
  void count_step(int iterations);
  /// Whether a new factor would pay.
  [[nodiscard]] bool worn() const;

  /// A few words on what it is.
  [[nodiscard]] std::string description() const;

  /// Where the factor was made and how worn it is; `restore` makes the same one again.
  void save(StateWriter& writer) const;
  void restore(StateReader& reader);

 private:
  SolveStatus factorize(const DampedBody::Linearization& at);
  SolveStatus prepare_cycles(const DampedBody::Linearization& at);

  const DampedBody& m_body;
  DampedBody::Linearization m_made_at;
  std::unique_ptr<LinearSolver> m_solver;
  std::unique_ptr<MultigridPreconditioner> m_cycles;  // in place of m_solver
  NodalRotations m_rotations;
  std::vector<Eigen::Matrix3d> m_rotations_then;  // when the factor was made
  std::vector<Eigen::Matrix3d> m_turns;           // R_i
  Eigen::VectorXd m_diagonal;                     // of H, free [N/m]
  Eigen::VectorXd m_stiffness_diagonal;           // of H without inertia, free [N/m]
  double m_mu = 0.0;
  double m_gamma = 0.0;
  bool m_analyzed = false;
  bool m_ready = false;
  int m_fresh_iterations = -1;  // of the first step after a renewal
  int m_excess_iterations = 0;  // spent since beyond those
};

}  // namespace twang::detail
