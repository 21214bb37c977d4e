// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

namespace twang::detail {

/// The clock that the stamps of a film tell.
///
/// A camera's clock is even; a file rounds it to ticks, and a film that was copied from another
/// file bears that one's rounding too (multiples of a millisecond in a tick of a microsecond).
struct FrameClock {
  bool even = false;  ///< the stamps are those of an even clock, rounded
  double fps = 0.0;   ///< of the even clock; else the slope of a line through the stamps [1/s]
  bool as_declared = false;    ///< even at the declared rate
  double grid_s = 0.0;         ///< to which the stamps are rounded, a tick or coarser [s]
  double jitter_s = 0.0;       ///< rms distance of the stamps from the even clock [s]
  std::vector<double> counts;  ///< frames elapsed since the first, one a stamp, increasing
};

/// Reads the clock from stamps.
///
/// They are held against the declared rate, then the rate of a line through them or a usual rate
/// (whole, or whole / 1.001) that this cannot be told from.
///
/// @param stamps_s  two or more, increasing [s]
/// @param tick_s    resolution of the stamps [s]
[[nodiscard]] FrameClock read_frame_clock(const std::vector<double>& stamps_s,
                                          double tick_s,
                                          std::optional<double> declared_fps);

/// Whether a rate is one of the television rates, a multiple of 24 or 30 over 1.001: that multiple.
[[nodiscard]] std::optional<int> ntsc_multiple(double fps);

}  // namespace twang::detail
