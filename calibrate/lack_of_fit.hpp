// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/trace.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "rigs/rig.hpp"

namespace twang {

/// What the part of the residual that is no noise adds to the uncertainty of a sinusoid.
///
/// A film's residual exceeds what the samples' sigmas explain where something follows the motion
/// instead of scattering: a codec that predicts a marker's place from the frame before, blur, a
/// part that is not quite linear. Taken as a constant c off the envelope, which least squares over
/// several decay times answers, by the projection of c on exp(−d t) and t exp(−d t), with
///
///     δd / d = 4 c / A,    c² = residual² − sigma²
///
/// and to one in quadrature with the same change of the angular frequency.
struct LackOfFit {
  double frequency_spread_hz = 0.0;  ///< [Hz]
  double decay_spread_per_s = 0.0;   ///< [1/s]
};

/// Of the strongest sinusoid, in the first column that has sigmas: an observable of the rig's, by
/// its markers' `<marker>.sigma_mm`, or a coordinate of a marker. None without sigmas.
[[nodiscard]] LackOfFit lack_of_fit(const Rig& rig,
                                    const Trace& trace,
                                    const InversionResult& inversion);

}  // namespace twang
