// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

namespace twang {

/// What several channels share in a damped sinusoid: its place in the complex plane,
/// `u = exp(-d dt + i 2 pi f dt)`.
struct DampedPole {
  double frequency_hz = 0.0;  ///< f [Hz]
  double decay_per_s = 0.0;   ///< d [1/s], negative: growing
};

/// A pole proposed by a finder, with what it thinks of it.
struct PoleCandidate {
  DampedPole pole;
  double amplitude = 0.0;  ///< its own estimate of the strength at the first sample, signal's unit
  double error = 0.0;      ///< its own relative error [-]
};

/// The finite samples of one channel within the window that is inverted.
struct SampleSeries {
  std::string name;
  Eigen::VectorXd time_s;      ///< increasing, from the origin of this series [s]
  Eigen::VectorXd value;       ///< in the channel's unit
  Eigen::VectorXd sigma = {};  ///< stated standard deviations; empty: none, or all the same
};

/// Evenly spaced samples.
struct EvenSeries {
  double step_s = 0.0;  ///< [s]
  Eigen::VectorXd value;
};

}  // namespace twang
