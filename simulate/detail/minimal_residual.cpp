// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/minimal_residual.hpp"

#include <cmath>

namespace twang::detail {

MinimalResidualResult minimal_residual(const VectorMap& A,
                                       const VectorMap& precondition,
                                       const Eigen::VectorXd& b,
                                       const Eigen::VectorXd& Pb,
                                       double tolerance,
                                       int max_iterations) {
  MinimalResidualResult result;
  result.x = Eigen::VectorXd::Zero(b.size());
  const double start = std::sqrt(b.dot(Pb));
  if (!(start > 0.0)) {
    result.finite = start == 0.0;
    result.converged = result.finite;
    return result;
  }
  // Lanczos vectors v (unscaled), their preconditioned z, the update directions w, and the Givens
  // rotations (c, s) of the tridiagonal matrix; suffix 0: one before.
  Eigen::VectorXd v0 = Eigen::VectorXd::Zero(b.size());
  Eigen::VectorXd v = b;
  Eigen::VectorXd z = Pb;
  Eigen::VectorXd w0 = Eigen::VectorXd::Zero(b.size());
  Eigen::VectorXd w = w0;
  double beta0 = 1.0;
  double beta = start;
  double c0 = 1.0;
  double c = 1.0;
  double s0 = 0.0;
  double s = 0.0;
  double eta = start;
  while (result.iterations < max_iterations) {
    z /= beta;
    const Eigen::VectorXd Az = A(z);
    const double alpha = Az.dot(z);
    const Eigen::VectorXd v1 = Az - (alpha / beta) * v - (beta / beta0) * v0;
    const Eigen::VectorXd z1 = precondition(v1);
    const double beta1_squared = z1.dot(v1);
    if (!std::isfinite(alpha) || !std::isfinite(beta1_squared)) {
      result.finite = false;
      return result;
    }
    const double beta1 = std::sqrt(std::max(beta1_squared, 0.0));
    const double rho0 = c * alpha - c0 * s * beta;
    const double rho = std::hypot(rho0, beta1);
    if (!(rho > 0.0)) return result;
    const Eigen::VectorXd w1 = (z - (s0 * beta) * w0 - (s * alpha + c0 * c * beta) * w) / rho;
    const double c1 = rho0 / rho;
    const double s1 = beta1 / rho;
    result.x += (c1 * eta) * w1;
    eta *= -s1;
    ++result.iterations;
    result.relative_residual = std::abs(eta) / start;
    if (result.relative_residual <= tolerance || beta1 == 0.0) {
      result.converged = true;
      return result;
    }
    v0 = v;
    v = v1;
    z = z1;
    w0 = w;
    w = w1;
    beta0 = beta;
    beta = beta1;
    c0 = c;
    c = c1;
    s0 = s;
    s = s1;
  }
  return result;
}

}  // namespace twang::detail
