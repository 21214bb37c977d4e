// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace twang::bench {

/// One damped sinusoid of unit amplitude in white noise, 2 s at 240 Hz, drawn again and again with
/// random phase and noise.
struct DrawnSinusoid {
  double frequency_hz = 20.0;  ///< of the damped motion [Hz]
  double damping_ratio = 0.05;
  double snr_db = 40.0;  ///< amplitude at the first sample over sigma [dB]
};

/// What the estimates of f or d show over all draws.
struct Spread {
  double rmse_over_bound = 0.0;  ///< root mean of (error / Cramer-Rao bound)² [-]
  double within_one = 0.0;       ///< part of the draws with an error below the stated sigma [-]
  double within_two = 0.0;       ///< and below twice that [-]
};

struct DrawStatistics {
  int draws = 0;
  int missed = 0;  ///< draws without any mode, in no other figure
  int extra = 0;   ///< modes beside the strongest, in all draws
  Spread frequency;
  Spread decay;
  /// Root mean of (error / Cramer-Rao bound)² of least squares itself: the true number of modes,
  /// started at the truth. A search can do better only by what it takes off of its bias [-].
  double best_frequency = 0.0;
  double best_decay = 0.0;
};

/// Inverts `draws` records at the default settings and compares the strongest mode of each with the
/// truth.
///
/// The bound is that of a fit with amplitude, phase and offset free, at the phase of each draw. It
/// is one of small noise: where the error of d is no longer small beside d, as in a mode gone
/// within some samples, least squares does not attain it, and `DrawStatistics::best_decay` says by
/// how much.
[[nodiscard]] DrawStatistics draw_sinusoids(const DrawnSinusoid& truth,
                                            int draws,
                                            std::uint32_t first_seed);

/// How many of `draws` records of white noise alone, 2 s at 240 Hz, are given a mode.
[[nodiscard]] int count_false_alarms(int draws, std::uint32_t first_seed);

/// In how many of `draws` records a mode of 20 Hz, 20 sigma and damping ratio 0.05 is found, a
/// mode within 5 % of its frequency.
[[nodiscard]] int count_detections(int draws, std::uint32_t first_seed);

}  // namespace twang::bench
