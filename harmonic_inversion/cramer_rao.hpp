// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/synthesize.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang {

/// The least standard deviations that unbiased estimates of f and d can have.
struct CramerRaoBound {
  double frequency_hz = 0.0;  ///< [Hz]
  double decay_per_s = 0.0;   ///< [1/s]
};

/// The Cramer-Rao bounds of damped sinusoids in white noise, one a sinusoid, with all amplitudes,
/// phases and the offset as nuisances.
///
///     bound² = diag((J^T J)^-1) sigma²,   J = d y(t_n) / d(f, d, A, theta of each, offset)
///
/// @param sinusoids  amplitudes above 0
/// @param options    rate, duration and noise of the record; stamps without jitter, none missing
/// @throws InputError if an option is out of range
[[nodiscard]] std::vector<CramerRaoBound> cramer_rao_bounds(
    const std::vector<SinusoidTruth>& sinusoids, const SynthesisOptions& options);

/// The same in noise whose standard deviation differs from sample to sample: rows of J and the
/// noise are divided by it.
///
/// @param time_s  of the samples, from the release [s]
/// @param sigma   of each, above 0
/// @throws InputError if sizes disagree or a sigma is not above 0
[[nodiscard]] std::vector<CramerRaoBound> cramer_rao_bounds(
    const std::vector<SinusoidTruth>& sinusoids,
    const Eigen::VectorXd& time_s,
    const Eigen::VectorXd& sigma);

}  // namespace twang
