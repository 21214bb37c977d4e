// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/checked_signal.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

namespace twang {

/// Frequency and decay from amplitude and phase of the Morlet wavelet transform at the mode's
/// frequency [Ruzzene et al. 1997; Staszewski 1997], other modes left in the signal.
///
///     W(t) = ∫ y(s) exp(-i ω (s - t)) exp(-(s - t)² / 2 τ²) ds / normalization
///
/// as the weighted projection onto 1, cos and sin, which holds for uneven and missing samples
/// [Foster 1996, AJ 112, 1709]. Of y = A exp(-d s) cos(ω' s + θ) it makes
///
///     W(t) = A exp((-d + i (ω' - ω))² τ² / 2) exp(-d t + i (ω' t + θ)):
///
/// the wavelet's bias is a constant factor, so the slopes of ln|W| and of the phase are unbiased.
/// That holds outside the cone of influence, which reaches further at the beginning than at the
/// end: what W(t) sees of a decay stands about t - d τ².
///
/// τ is the one of several widths that gives the smallest sigma. Left out are the times when
/// another mode leaks in, by exp((d_k² - d² - (ω_k - ω)²) τ² / 2) A_k / A exp((d - d_k) t), and
/// those when |W| sinks into the noise. The sigmas are those of white noise of the residual's size
/// carried through the linear W, with the correlation of its values.
[[nodiscard]] DecayCheck morlet_ridge(const CheckedSignal& signal);

}  // namespace twang
