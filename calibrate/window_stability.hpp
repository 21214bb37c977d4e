// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/damped_sinusoid.hpp"
#include "core/trace.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <string>
#include <vector>

namespace twang {

/// What the choice of the window adds to the uncertainty of the strongest sinusoid.
struct WindowStability {
  double frequency_spread_hz = 0.0;  ///< [Hz]
  double decay_spread_per_s = 0.0;   ///< [1/s]
  int windows = 0;                   ///< narrower windows in which the sinusoid was found again
};

/// Inverts narrower windows, later starts and an earlier end, and compares the strongest sinusoid
/// with that of the whole.
///
/// With white noise alone an estimate from a part of the data differs from that of the whole by
/// sqrt(s_part² - s_whole²) [Hausman 1978]; what goes beyond that is what the noise does not
/// explain: blur and compression that change with the amplitude, friction, a stiffness that depends
/// on it. The largest such excess is returned.
[[nodiscard]] WindowStability window_stability(const Trace& trace,
                                               const std::vector<std::string>& columns,
                                               const InversionResult& whole,
                                               const InversionOptions& options);

/// The sinusoid with these spreads added to its sigmas in quadrature.
[[nodiscard]] DampedSinusoid widened(DampedSinusoid sinusoid, const WindowStability& stability);

}  // namespace twang
