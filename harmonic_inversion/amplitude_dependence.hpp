// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/damped_pole.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <string>
#include <vector>

namespace twang {

/// How the strongest mode's frequency and decay change while its amplitude falls.
struct AmplitudeDependence {
  std::vector<AmplitudeWindow> windows;  ///< of each recording, earliest first
  /// Changes of f and d where the amplitude grows by a factor e, over their sigmas [-]; 0 where
  /// there are too few windows to say.
  double frequency_trend = 0.0;
  double decay_trend = 0.0;
  std::string sentence;  ///< empty where neither differs beyond its sigma
};

/// Fits the strongest mode anew in windows one after another, everything else held as found:
///
///     y_c - others = exp(-d t) (a_c cos 2 pi f t + b_c sin 2 pi f t)
///
/// Each window is at least two periods long, and the last ends where the mode sinks to three times
/// the residual. The sigmas are those of the windows' own residuals, taken together. f and d are
/// then fitted by straight lines over ln A; a trend counts beyond three of its sigmas.
///
/// Friction shows as a decay that rises while the amplitude falls, a stiffness that depends on it
/// as a frequency that moves.
///
/// @param series       one a recording and channel, recording by recording, as they were inverted
/// @param num_traces   recordings
[[nodiscard]] AmplitudeDependence amplitude_dependence(const std::vector<SampleSeries>& series,
                                                       std::size_t num_traces,
                                                       const InversionResult& whole);

}  // namespace twang
