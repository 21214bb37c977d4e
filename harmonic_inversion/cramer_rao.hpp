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

}  // namespace twang
