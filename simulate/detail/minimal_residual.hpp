// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <functional>

namespace twang::detail {

using VectorMap = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

struct MinimalResidualResult {
  Eigen::VectorXd x;
  int iterations = 0;
  double relative_residual = 1.0;  ///< in the norm rᵀ P⁻¹ r, over that of b [-]
  bool converged = false;
  bool finite = true;  ///< false: a product was not finite, x is the last sound iterate
};

/// Solves A x = b for symmetric A, definite or not, with a symmetric positive definite
/// preconditioner P: MINRES [Paige & Saunders 1975].
///
/// Every iterate lowers rᵀ P⁻¹ r, so x is a direction of descent for that norm of a nonlinear
/// residual whose Jacobian is A.
///
/// @param Pb  P⁻¹ b, which the caller knows already
[[nodiscard]] MinimalResidualResult minimal_residual(const VectorMap& A,
                                                     const VectorMap& precondition,
                                                     const Eigen::VectorXd& b,
                                                     const Eigen::VectorXd& Pb,
                                                     double tolerance,
                                                     int max_iterations);

}  // namespace twang::detail
