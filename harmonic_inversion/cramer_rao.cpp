// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/cramer_rao.hpp"

#include "core/constants.hpp"

#include <Eigen/QR>

#include <cmath>

namespace twang {

using Eigen::Index;
using Eigen::MatrixXd;

std::vector<CramerRaoBound> cramer_rao_bounds(const std::vector<SinusoidTruth>& sinusoids,
                                              const SynthesisOptions& options) {
  options.check();
  const auto samples =
      static_cast<Index>(std::floor(options.duration_s * options.rate_hz + 1e-9)) + 1;
  const auto unknowns = 4 * static_cast<Index>(sinusoids.size()) + 1;
  MatrixXd jacobian(samples, unknowns);
  jacobian.col(unknowns - 1).setOnes();
  for (std::size_t k = 0; k < sinusoids.size(); ++k) {
    const SinusoidTruth& s = sinusoids[k];
    for (Index i = 0; i < samples; ++i) {
      const double t = static_cast<double>(i) / options.rate_hz;
      const double angle = kTwoPi * s.frequency_hz * t + s.phase_rad;
      const double envelope = std::exp(-s.decay_per_s * t);
      const double sine = envelope * std::sin(angle);
      const double cosine = envelope * std::cos(angle);
      jacobian.block<1, 4>(i, 4 * static_cast<Index>(k)) << s.amplitude * kTwoPi * t * cosine,
          -s.amplitude * t * sine, sine, s.amplitude * cosine;
    }
  }
  // By R of J = Q R, not by J^T J: columns of one sinusoid are nearly parallel at heavy damping.
  const MatrixXd r = Eigen::HouseholderQR<MatrixXd>(jacobian)
                         .matrixQR()
                         .topRows(unknowns)
                         .triangularView<Eigen::Upper>();
  const MatrixXd inverse =
      r.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(unknowns, unknowns));
  std::vector<CramerRaoBound> out;
  for (Index k = 0; k < static_cast<Index>(sinusoids.size()); ++k) {
    out.push_back({options.noise_sigma * inverse.row(4 * k).norm(),
                   options.noise_sigma * inverse.row(4 * k + 1).norm()});
  }
  return out;
}

}  // namespace twang
