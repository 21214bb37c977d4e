// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/cramer_rao.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <Eigen/QR>
#include <fmt/format.h>

#include <cmath>

namespace twang {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<CramerRaoBound> cramer_rao_bounds(const std::vector<SinusoidTruth>& sinusoids,
                                              const SynthesisOptions& options) {
  options.check();
  const auto samples =
      static_cast<Index>(std::floor(options.duration_s * options.rate_hz + 1e-9)) + 1;
  VectorXd time_s(samples);
  for (Index i = 0; i < samples; ++i) time_s(i) = static_cast<double>(i) / options.rate_hz;
  // For unit noise first: without noise the bound is 0, not undefined.
  std::vector<CramerRaoBound> out = cramer_rao_bounds(sinusoids, time_s, VectorXd::Ones(samples));
  for (CramerRaoBound& bound : out) {
    bound.frequency_hz *= options.noise_sigma;
    bound.decay_per_s *= options.noise_sigma;
  }
  return out;
}

std::vector<CramerRaoBound> cramer_rao_bounds(const std::vector<SinusoidTruth>& sinusoids,
                                              const VectorXd& time_s,
                                              const VectorXd& sigma) {
  if (sigma.size() != time_s.size() || !(sigma.array() > 0.0).all()) {
    throw InputError(
        fmt::format("cramer_rao_bounds: {} standard deviations, the least {}, expected {} above 0",
                    sigma.size(),
                    sigma.size() > 0 ? sigma.minCoeff() : 0.0,
                    time_s.size()));
  }
  const Index samples = time_s.size();
  const auto unknowns = 4 * static_cast<Index>(sinusoids.size()) + 1;
  MatrixXd jacobian(samples, unknowns);
  jacobian.col(unknowns - 1).setOnes();
  for (std::size_t k = 0; k < sinusoids.size(); ++k) {
    const SinusoidTruth& s = sinusoids[k];
    for (Index i = 0; i < samples; ++i) {
      const double t = time_s(i);
      const double angle = kTwoPi * s.frequency_hz * t + s.phase_rad;
      const double envelope = std::exp(-s.decay_per_s * t);
      const double sine = envelope * std::sin(angle);
      const double cosine = envelope * std::cos(angle);
      jacobian.block<1, 4>(i, 4 * static_cast<Index>(k)) << s.amplitude * kTwoPi * t * cosine,
          -s.amplitude * t * sine, sine, s.amplitude * cosine;
    }
  }
  jacobian.array().colwise() /= sigma.array();
  // By R of J = Q R, not by J^T J: columns of one sinusoid are nearly parallel at heavy damping.
  const MatrixXd r = Eigen::HouseholderQR<MatrixXd>(jacobian)
                         .matrixQR()
                         .topRows(unknowns)
                         .triangularView<Eigen::Upper>();
  const MatrixXd inverse =
      r.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(unknowns, unknowns));
  std::vector<CramerRaoBound> out;
  for (Index k = 0; k < static_cast<Index>(sinusoids.size()); ++k) {
    out.push_back({inverse.row(4 * k).norm(), inverse.row(4 * k + 1).norm()});
  }
  return out;
}

}  // namespace twang
