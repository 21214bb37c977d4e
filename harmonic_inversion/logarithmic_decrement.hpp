// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/checked_signal.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

namespace twang {

/// Frequency and decay from the successive extrema of the mode, of both signs:
///
///     ln |y(t_k)| = ln A - d t_k,   t_k = t_0 + k / (2 f)
///
/// Parabolas through the three samples about each extremum give times and heights, and straight
/// lines through these a first f and d. The samples about each extremum that this line foretells
/// are then fitted anew by exp(-d t) (a cos 2 pi f t + b sin 2 pi f t), t from the extremum, which
/// takes away the parabola's error and the bias of picking the highest of noisy samples; amplitude
/// and phase of these are the points of the lines, weighted by noise / A. Only extrema foretold to
/// stand well above the noise count.
[[nodiscard]] DecayCheck logarithmic_decrement(const CheckedSignal& signal);

}  // namespace twang
