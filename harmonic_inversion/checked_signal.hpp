// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/damped_sinusoid.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang {

/// The samples of one channel on which the strongest mode is checked; time from the origin.
struct CheckedSignal {
  Eigen::VectorXd time_s;             ///< increasing [s]
  Eigen::VectorXd value;              ///< without offset and drift
  Eigen::VectorXd mode_alone;         ///< also without the other modes
  double noise = 0.0;                 ///< rms of the fit's residual, its unknowns counted
  std::size_t channel = 0;            ///< in the modes
  std::vector<DampedSinusoid> modes;  ///< the one checked first

  [[nodiscard]] const DampedSinusoid& mode() const { return modes.front(); }
  [[nodiscard]] double amplitude(std::size_t k = 0) const {
    return modes[k].channels[channel].amplitude;
  }
};

}  // namespace twang
