// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"

#include <algorithm>
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
  /// b = 2 d / lambda of the damping b K that has this f and d [s].
  [[nodiscard]] double damping_stiffness_b_s() const { return 2.0 * decay_per_s / lambda_per_s2(); }

  /// The standard deviation of a function of f and d, to first order, from its derivatives: f and d
  /// are correlated. nan where their own sigmas are.
  ///
  ///     sigma² = g^T C g,   C the covariance of (f, d)
  [[nodiscard]] double sigma_of(double by_frequency, double by_decay) const {
    const double variance = std::pow(by_frequency * frequency_sigma_hz, 2) +
                            std::pow(by_decay * decay_sigma_per_s, 2) +
                            2.0 * by_frequency * by_decay * frequency_decay_covariance;
    return std::sqrt(std::max(variance, 0.0 * variance));  // the product keeps a nan a nan
  }
  /// One standard deviation of each of the above.
  [[nodiscard]] double lambda_sigma_per_s2() const {
    return sigma_of(2.0 * kTwoPi * kTwoPi * frequency_hz, 2.0 * decay_per_s);
  }
  [[nodiscard]] double natural_frequency_sigma_hz() const {
    return 0.5 * natural_frequency_hz() * lambda_sigma_per_s2() / lambda_per_s2();
  }
  [[nodiscard]] double damping_ratio_sigma() const {
    const double omega = kTwoPi * frequency_hz;
    const double scale = omega / std::pow(lambda_per_s2(), 1.5);
    return sigma_of(-kTwoPi * decay_per_s * scale, omega * scale);
  }
  [[nodiscard]] double damping_stiffness_b_sigma_s() const {
    const double lambda = lambda_per_s2();
    const double b = damping_stiffness_b_s();
    return sigma_of(-b / lambda * 2.0 * kTwoPi * kTwoPi * frequency_hz,
                    2.0 / lambda - b / lambda * 2.0 * decay_per_s);
  }
};

}  // namespace twang
