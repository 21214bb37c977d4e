// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"

#include <cmath>
#include <string>
#include <vector>

namespace twang {

/// Amplitude and phase with which one channel takes part in a damped sinusoid.
struct SinusoidInChannel {
  std::string channel;
  double amplitude = 0.0;         ///< A > 0 at the time origin, in the channel's unit
  double phase_rad = 0.0;         ///< theta in (-pi, pi] [rad]
  double amplitude_sigma = kNaN;  ///< one standard deviation, in the channel's unit
  double phase_sigma_rad = kNaN;  ///< one standard deviation [rad]
};

/// A damped sinusoid of a signal, `A exp(-d (t - t0)) sin(2 pi f (t - t0) + theta)` in each of its
/// channels [paper, eq. (14)].
///
/// Not to be confused with an eigenmode, which belongs to a mesh.
struct DampedSinusoid {
  double frequency_hz = 0.0;                ///< f, of the damped motion [Hz]
  double frequency_sigma_hz = kNaN;         ///< one standard deviation [Hz]
  double decay_per_s = 0.0;                 ///< d in exp(-d t) [1/s]
  double decay_sigma_per_s = kNaN;          ///< one standard deviation [1/s]
  double frequency_decay_covariance = 0.0;  ///< cov(f, d) [Hz/s]
  double error = kNaN;                      ///< the finder's own relative error of the mode [-]
  std::vector<SinusoidInChannel> channels;

  /// lambda = (2 pi f)² + d², the eigenvalue of the undamped motion [1/s²].
  [[nodiscard]] double lambda_per_s2() const {
    return std::pow(kTwoPi * frequency_hz, 2) + decay_per_s * decay_per_s;
  }
  /// sqrt(lambda) / 2 pi [Hz].
  [[nodiscard]] double natural_frequency_hz() const { return std::sqrt(lambda_per_s2()) / kTwoPi; }
  /// d / sqrt(lambda) [-].
  [[nodiscard]] double damping_ratio() const { return decay_per_s / std::sqrt(lambda_per_s2()); }
};

}  // namespace twang
