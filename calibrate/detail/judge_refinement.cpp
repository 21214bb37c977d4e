// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/detail/judge_refinement.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <cmath>

namespace twang::detail {

Eigen::Matrix2d from_parameters() {
  Eigen::Matrix2d from;
  from << 1.0, 0.0, -0.5, 1.0;
  return from;
}

Eigen::Array2d variance_between_halves(const Eigen::MatrixXd& columns,
                                       const Eigen::VectorXd& left,
                                       double variance) {
  const Eigen::Index n = left.size() / 2;
  const Eigen::Matrix2d from = from_parameters();
  Eigen::Vector2d apart = Eigen::Vector2d::Zero();
  Eigen::Array2d by_noise = Eigen::Array2d::Zero();
  for (const bool second : {false, true}) {
    const Eigen::MatrixXd J = second ? columns.bottomRows(n) : columns.topRows(n);
    const Eigen::VectorXd r = second ? left.tail(n) : left.head(n);
    const Eigen::LDLT<Eigen::MatrixXd> normal((J.transpose() * J).eval());
    const Eigen::VectorXd step = normal.solve(J.transpose() * r);
    const Eigen::MatrixXd covariance =
        normal.solve(Eigen::MatrixXd::Identity(columns.cols(), columns.cols()));
    apart += (second ? 1.0 : -1.0) * (from * step.head<2>());
    by_noise +=
        variance * (from * covariance.topLeftCorner<2, 2>() * from.transpose()).diagonal().array();
  }
  const Eigen::Array2d excess = 0.25 * (apart.array().square() - by_noise);
  return excess.isFinite().all() ? excess.max(0.0).eval() : Eigen::Array2d::Zero().eval();
}

std::string fault_of(const RefinementFit& fit) {
  constexpr double kMostLeft = 0.1;         // of the amplitude
  constexpr double kVaguestModulus = 0.05;  // one sigma
  constexpr double kVaguestDamping = 0.5;   // likewise
  const double modulus_sigma = std::sqrt(fit.covariance(0, 0));
  const double damping_sigma = std::sqrt(fit.covariance(1, 1));
  if (!(modulus_sigma <= kVaguestModulus && damping_sigma <= kVaguestDamping))
    return fmt::format(
        "the trace tells E_n to {:.2g} % and b to {:.2g} % (one sigma), which must be {:.0f} % and "
        "{:.0f} % or less",
        100.0 * modulus_sigma,
        100.0 * damping_sigma,
        100.0 * kVaguestModulus,
        100.0 * kVaguestDamping);
  if (!(fit.residual_rel <= kMostLeft))
    return fmt::format(
        "the simulation does not follow the trace, {:.2g} % of the amplitude are left (rms), which "
        "must be {:.0f} % or less",
        100.0 * fit.residual_rel,
        100.0 * kMostLeft);
  return {};
}

std::string agreement_of(const RefinementFit& fit) {
  constexpr double kByChance = 5.99;  // chi² of two, 95 %
  const double moved = fit.change.dot(fit.covariance.ldlt().solve(fit.change));
  if (moved > kByChance && fit.residual_rel < fit.linear_residual_rel) return {};
  return fmt::format(
      "the simulation changes E_n by {:+.2f} ± {:.2f} % and b by {:+.2f} ± {:.2f} %, which is "
      "nothing that the trace tells from chance (rms left {:.2g} % of the amplitude, {:.2g} % "
      "before)",
      100.0 * std::expm1(fit.change[0]),
      100.0 * std::sqrt(fit.covariance(0, 0)),
      100.0 * std::expm1(fit.change[1]),
      100.0 * std::sqrt(fit.covariance(1, 1)),
      100.0 * fit.residual_rel,
      100.0 * fit.linear_residual_rel);
}

std::string fault_of_view(const SimulatedObservable& observable,
                          const Eigenmodes& modes,
                          int mode) {
  constexpr double kHardly = 0.03;
  const Eigen::VectorXd shape = unit_observable_shape(modes, mode_cluster(modes, mode), observable);
  double seen = 0.0;
  if (shape.size() > 0) {
    const double peak = Eigen::Map<const Eigen::Matrix3Xd>(shape.data(), 3, shape.size() / 3)
                            .colwise()
                            .norm()
                            .maxCoeff();
    seen = observable.metres_per_unit() / peak;
  }
  if (seen >= kHardly) return {};
  return fmt::format(
      "eigenmode {} of the mesh moves the observable by only {:.2g} % of what it moves the part "
      "elsewhere, so that the trace hardly tells how far the part bends",
      mode + 1,
      100.0 * seen);
}

}  // namespace twang::detail
