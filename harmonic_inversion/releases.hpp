// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"
#include "core/trace.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <string>
#include <utility>
#include <vector>

namespace twang {

/// The parts of a trace that hold one release each: from the calm or the pull before it to the last
/// sample before the next disturbance. A record that moves freely from its first sample, or holds
/// one release, is one part: all of it.
///
/// @param channels  of `trace`, judged together
/// @param options   `start_s` and `end_s` bound what is looked at
/// @throws InputError if a channel is missing, nothing lies between start and end, or an option is
/// out of range
[[nodiscard]] std::vector<Trace> cut_at_releases(const Trace& trace,
                                                 const std::vector<std::string>& channels,
                                                 const InversionOptions& options = {});

/// What several recordings, or several releases of one, say together and each alone.
struct RepeatedInversion {
  InversionResult joint;               ///< all share their poles
  std::vector<InversionResult> alone;  ///< one a recording
  /// Standard deviation between the recordings of the mode nearest to the joint's strongest [Hz],
  /// [1/s]; nan with fewer than two that show it.
  double frequency_scatter_hz = kNaN;
  double decay_scatter_per_s = kNaN;

  /// The mode of `alone[n]` nearest to the joint's strongest; nullptr if there is none within a
  /// fifth of its frequency.
  [[nodiscard]] const DampedSinusoid* mode_alone(std::size_t n) const;
};

/// Compares what recordings of one part say together with what each says alone.
[[nodiscard]] RepeatedInversion relate_repeats(InversionResult joint,
                                               std::vector<InversionResult> alone);

/// Inverts several recordings of one part together and each alone, and compares.
/// @throws InputError as `invert_repeats`
[[nodiscard]] RepeatedInversion compare_repeats(const std::vector<Trace>& traces,
                                                const std::vector<std::string>& channels,
                                                const InversionOptions& options = {});

/// As `modes_to_json(repeated.joint)`, with `repeats`, one entry a recording, and `repeat_scatter`.
[[nodiscard]] std::string modes_to_json(const RepeatedInversion& repeated);
/// Several columns one by one, as there.
[[nodiscard]] std::string modes_to_json(
    const std::vector<std::pair<std::string, RepeatedInversion>>& columns);

}  // namespace twang
