// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/trace.hpp"

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// The part of a trace in which a part vibrates freely.
struct FreeMotion {
  double start_s = 0.0;             ///< first sample safely in free motion [s]
  double end_s = 0.0;               ///< last sample before the next disturbance [s]
  std::optional<double> release_s;  ///< last sample seen at rest or held, if there is one [s]
  bool ends_early = false;          ///< a disturbance follows
  std::string note;                 ///< one sentence: what was chosen and why; empty: all of it
};

/// Finds the first release in a trace: a rest, a hold or a slow pull, then sudden motion that
/// swings back.
///
/// Judged by the speed, from one sample to the next, or from the mean of some samples to the mean
/// of the next where noise hides the motion. Let b be the highest speed, glitches apart. A release
/// is seen if the speed first passes b / 4 after a calm below b / 8 (but for one sample in ten)
/// that lasted at least half as long as the first swing, so that the turning point of a vibration
/// is none. Free motion is taken to start past the highest speed of the first swing: a clamp or
/// thread that lets go over a few samples is then gone. A record that moves freely from its first
/// sample is used from there. It ends before the pull that leads to the next release, before
/// a pull in which the samples end, or with them.
///
/// @param channels  of `trace`, judged together: motion in one unit, the suffix of the name, is
/// compared as it is, other by each channel's range; where no release is seen so, as where most
/// channels hold noise alone, each by its noise
/// @param from_s    samples before are not looked at [s]
/// @param to_s      nor those after [s]
[[nodiscard]] FreeMotion find_free_motion(const Trace& trace,
                                          const std::vector<std::string>& channels,
                                          double from_s,
                                          double to_s);

/// The same, though a pull may have begun before `to_s` that only what follows shows to be one:
/// the samples after `to_s` are looked at for that alone.
[[nodiscard]] FreeMotion find_free_motion_until(const Trace& trace,
                                                const std::vector<std::string>& channels,
                                                double from_s,
                                                double to_s);

}  // namespace twang
