// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/fit_material.hpp"

#include "core/constants.hpp"
#include "core/dense_algebra.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

bool decay_sigmas_known(const std::vector<DampedSinusoid>& sinusoids) {
  return std::all_of(sinusoids.begin(), sinusoids.end(), [](const DampedSinusoid& s) {
    return std::isfinite(s.decay_sigma_per_s) && s.decay_sigma_per_s > 0.0;
  });
}

}  // namespace

DampedTarget damped_target(const DampedSinusoid& sinusoid) {
  const double f = sinusoid.frequency_hz;
  const double d = sinusoid.decay_per_s;
  const double lambda = sinusoid.lambda_per_s2();
  if (!(f >= 0.0) || !(d >= 0.0) || !(lambda > 0.0) || !std::isfinite(lambda)) {
    throw InputError(fmt::format(
        "the damped sinusoid has frequency {} Hz and decay {} 1/s, both must be >= 0 and finite "
        "and one of them above 0",
        f,
        d));
  }
  DampedTarget target;
  target.lambda_per_s2 = lambda;
  target.lambda_sigma_per_s2 = sinusoid.lambda_sigma_per_s2();
  target.damping_stiffness_b_s = sinusoid.damping_stiffness_b_s();
  target.damping_stiffness_b_sigma_s = sinusoid.damping_stiffness_b_sigma_s();
  return target;
}

FrequencyAndDecay frequency_and_decay(double lambda_per_s2, double a_per_s, double b_s) {
  const double d = 0.5 * (a_per_s + b_s * lambda_per_s2);
  const double w2 = lambda_per_s2 - d * d;
  return {w2 > 0.0 ? std::sqrt(w2) / kTwoPi : 0.0, d};
}

double rescaled_modulus(double modulus_pa, double target_lambda_per_s2, double mesh_lambda_per_s2) {
  return modulus_pa * target_lambda_per_s2 / mesh_lambda_per_s2;
}

RayleighFit fit_rayleigh(const std::vector<DampedSinusoid>& sinusoids) {
  const auto n = static_cast<Eigen::Index>(sinusoids.size());
  const bool weighted = decay_sigmas_known(sinusoids);
  Eigen::MatrixXd A(n, 2);
  Eigen::VectorXd d(n);
  double largest = 0.0;
  for (const DampedSinusoid& s : sinusoids) largest = std::max(largest, s.lambda_per_s2());
  for (Eigen::Index i = 0; i < n; ++i) {
    const DampedSinusoid& s = sinusoids[static_cast<std::size_t>(i)];
    const double weight = weighted ? 1.0 / s.decay_sigma_per_s : 1.0;
    // The second unknown is b times the largest lambda, so that both columns are of one size.
    A.row(i) << 0.5 * weight, 0.5 * weight * s.lambda_per_s2() / largest;
    d(i) = weight * s.decay_per_s;
  }
  const bool enough = n >= 2 && largest > 0.0;
  const LeastSquares fit = enough ? solve_least_squares(A, d) : LeastSquares{};
  if (fit.rank < 2) {
    throw InputError(fmt::format(
        "a and b of Rayleigh damping need damped sinusoids of two different frequencies, found {}",
        enough ? 1 : n));
  }
  return {fit.x(0), fit.x(1) / largest};
}

UncertaintyBudget modulus_budget(const DampedTarget& target,
                                 double mesh_relative_sigma,
                                 double between_repeats_rel,
                                 const Tolerance& tolerance,
                                 const ModulusSensitivities& sensitivities) {
  UncertaintyBudget budget;
  budget.statistical = target.lambda_sigma_per_s2 / target.lambda_per_s2;
  budget.repeats = between_repeats_rel;
  budget.mesh = mesh_relative_sigma;
  budget.clock = 2.0 * tolerance.clock_rel;  // lambda goes with frequency squared
  budget.dimension = std::abs(sensitivities.dimension_per_m) * tolerance.dimension_m;
  budget.density = std::abs(sensitivities.density) * tolerance.density_rel;
  budget.poissons_ratio = std::abs(sensitivities.poissons_ratio) * tolerance.poissons_ratio;
  return budget;
}

}  // namespace twang
