// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/damped_sinusoid.hpp"
#include "core/trace.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace twang {

/// One damped sinusoid to be put into a synthetic signal.
struct SinusoidTruth {
  double frequency_hz = 0.0;  ///< f [Hz]
  double decay_per_s = 0.0;   ///< d [1/s]
  double amplitude = 1.0;     ///< A at the release
  double phase_rad = 0.0;     ///< theta [rad]
};

struct SynthesisOptions {
  double rate_hz = 240.0;    ///< samples a second
  double duration_s = 2.0;   ///< the last sample stands before or at this time
  double offset = 0.0;       ///< added to all samples
  double drift_per_s = 0.0;  ///< added slope
  double noise_sigma = 0.0;  ///< standard deviation of white Gaussian noise
  double jitter_s = 0.0;     ///< half width of a uniform jitter of the true and stated times [s]
  double held_s =
      0.0;  ///< time before the release, at the value of the release; 0: free all along [s]
  double missing_part = 0.0;  ///< this part of the samples becomes nan, at random [-]
  std::uint32_t seed = 1;     ///< of noise, jitter and gaps
  std::string channel = "y";
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// A trace of damped sinusoids with known truth, for tests and demonstrations.
///
///     y(t) = offset + drift t + sum A exp(-d s) sin(2 pi f s + theta) + noise,   s = max(t - held,
///     0)
///
/// @throws InputError if an option is out of range
[[nodiscard]] Trace synthesize_sinusoids(const std::vector<SinusoidTruth>& sinusoids,
                                         const SynthesisOptions& options = {});

}  // namespace twang
