// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/damped_pole.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <optional>
#include <vector>

namespace twang {

/// Frequency and decay of the strongest sinusoid of a motion whose sinusoids are known from a
/// longer or a like one: what a tracked and a simulated motion of the same samples are compared by.
///
/// Least squares for this pole alone. The others keep theirs, amplitudes and offset are free. What
/// stands within a tenth of the strongest frequency is no sinusoid of its own: it is how a large
/// motion, whose frequency and decay change as it falls, is fitted by sinusoids at all.
///
/// @param samples  from any origin, in any unit
/// @param known    modes, the strongest first
/// @return nothing where the samples do not tell
[[nodiscard]] std::optional<DampedPole> fit_strongest_sinusoid(
    const SampleSeries& samples, const std::vector<DampedSinusoid>& known);

}  // namespace twang
