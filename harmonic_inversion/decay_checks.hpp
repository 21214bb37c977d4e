// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/damped_sinusoid.hpp"
#include "core/trace.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <string>
#include <vector>

namespace twang {

/// Checks frequency and decay of the strongest mode on the samples that were inverted, by two
/// methods that share nothing with the fit but its offset, drift and a first guess: the
/// logarithmic decrement (see `logarithmic_decrement`) and the Morlet wavelet (see `morlet_ridge`).
///
/// @param channel        of `trace`
/// @param result         an inversion of that trace
/// @param channel_index  of that channel in `result`
/// @return one entry a method, with a message where it has no value; none if `result` has no mode
/// @throws InputError if the trace has no such channel or the result no such index
[[nodiscard]] std::vector<DecayCheck> check_decay(const Trace& trace,
                                                  const std::string& channel,
                                                  const InversionResult& result,
                                                  std::size_t channel_index);

/// The same in the channel of `result` in which the strongest mode is strongest against its noise.
/// @throws InputError if `trace` has not that channel
[[nodiscard]] std::vector<DecayCheck> check_decay(const Trace& trace,
                                                  const InversionResult& result);

/// A sentence if a check's decay differs from the mode's by more than three of their joint sigmas
/// and by more than a fiftieth; else empty.
[[nodiscard]] std::string disagreement(const DecayCheck& check, const DampedSinusoid& mode);

/// The result with its `decay_checks` made on `trace`, and a note for each that disagrees.
[[nodiscard]] InversionResult with_decay_checks(InversionResult result, const Trace& trace);

}  // namespace twang
