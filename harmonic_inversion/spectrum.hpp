// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/trace.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <vector>

namespace twang {

/// Amplitude spectrum of a signal.
struct Spectrum {
  std::vector<double> frequency_hz;  ///< 0 to Nyquist [Hz]
  std::vector<double> amplitude;  ///< of a steady sinusoid at that frequency, in the signal's unit
};

/// One-sided amplitude spectrum (FFTW) of the samples between `start_s` and `end_s`: mean removed,
/// Hann window, padded to at least four times the length; missing and uneven samples are bridged by
/// linear interpolation first.
/// @throws InputError if fewer than 8 samples are finite
[[nodiscard]] Spectrum amplitude_spectrum(const Trace& trace,
                                          const Channel& channel,
                                          double start_s,
                                          double end_s);

/// The same of an inversion's model in its first channel, sampled as the trace is, in the window
/// that was inverted.
/// @throws InputError if the trace has not that channel, or as `amplitude_spectrum`
[[nodiscard]] Spectrum model_spectrum(const Trace& trace, const InversionResult& inversion);

}  // namespace twang
