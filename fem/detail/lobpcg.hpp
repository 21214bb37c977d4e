// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/termination.hpp"

#include <Eigen/Core>

#include <functional>
#include <string>

namespace twang {

/// K x = lambda M x with M positive definite and a preconditioner B near K^-1.
struct PreconditionedProblem {
  using Operator = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;
  Operator apply_stiffness;  ///< K x
  Operator apply_mass;       ///< M x
  Operator precondition;     ///< B x, symmetric and positive definite
  /// Eigenvectors already known, M-orthonormal; only what is M-orthogonal to them is sought.
  Eigen::MatrixXd known;
};

struct LobpcgOptions {
  int count = 1;             ///< eigenvalues wanted
  double tolerance = 1e-10;  ///< estimated relative error of each of these [-]
  /// The same for the guards behind them: good enough to see that none of those wanted is missing.
  double guard_tolerance = 0.1;
  int max_iterations = 100;
  std::function<void(int iteration, double worst)> progress = {};
};

struct LobpcgResult {
  Eigen::VectorXd lambda;   ///< (count), ascending
  Eigen::MatrixXd vectors;  ///< (size x count), M-orthonormal
  int iterations = 0;
  double worst_error = 0.0;  ///< estimated, of those wanted [-]
  Termination termination = Termination::NotRun;
  std::string message;
};

/// Smallest eigenvalues by the locally optimal block preconditioned conjugate gradient method
/// [Knyazev 2001]: Rayleigh-Ritz on the vectors, their preconditioned residuals and the last
/// changes. Converged vectors give no residuals more but stay in the basis (soft locking [Knyazev
/// 2007]).
///
/// The relative error of a Ritz value theta with residual r is r . K^-1 r / theta times
/// lambda_j / (lambda_j - theta), lambda_j being the next eigenvalue outside of the block; r . B r
/// / theta serves as its estimate.
///
/// @param start  (size x block), block >= count, the more the better; columns behind `count` are
/// guards
[[nodiscard]] LobpcgResult find_smallest_preconditioned(const PreconditionedProblem& problem,
                                                        Eigen::MatrixXd start,
                                                        const LobpcgOptions& options);

}  // namespace twang
