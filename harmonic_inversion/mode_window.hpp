// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace twang {

/// The samples of one window, without what is not the mode; time from its middle.
struct WindowSamples {
  std::vector<Eigen::VectorXd> time_s;  // one a channel
  std::vector<Eigen::VectorXd> value;
  double start_s = 0.0;  // in the recording's time
  double end_s = 0.0;
  std::size_t recording = 0;
  [[nodiscard]] Eigen::Index size() const {
    Eigen::Index sum = 0;
    for (const Eigen::VectorXd& channel : value) sum += channel.size();
    return sum;
  }
  [[nodiscard]] Eigen::Index num_unknowns() const {
    return 2 + 2 * static_cast<Eigen::Index>(value.size());
  }
};

/// The mode in one window: f, d and their covariance for unit variance of the residual.
struct WindowFit {
  double frequency_hz = 0.0;
  double decay_per_s = 0.0;
  double amplitude = 0.0;  // in the middle
  Eigen::Matrix2d covariance;
  double sum_of_squares = 0.0;
  Eigen::Index freedom = 0;
};

/// Least squares for f and d of one damped sinusoid and its two amplitudes a channel, by
/// Gauss-Newton; nothing if it does not converge.
///
///     y_c = exp(-d t) (a_c cos 2 pi f t + b_c sin 2 pi f t)
///
/// @param f  where to start [Hz]
/// @param d  likewise [1/s]
[[nodiscard]] std::optional<WindowFit> fit_window(const WindowSamples& samples, double f, double d);

}  // namespace twang
