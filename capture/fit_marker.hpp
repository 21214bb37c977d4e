// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/align_marker.hpp"

namespace twang {

/// A marker's template and placement, as fitted to one picture.
struct FittedMarker {
  MarkerTemplate marker;
  MarkerAlignment alignment;
};

/// Aligns a marker with size and slant free and chooses the blur that explains the picture best:
/// what is done once, in the first frame, so that later frames have a fixed reference.
///
/// @param start        rough placement, size within a third of the truth
/// @param farthest_px  gives up farther than this from the start [px]
/// @return             `alignment.converged` says whether there was a marker to fit
[[nodiscard]] FittedMarker fit_marker(const LumaFrame& frame,
                                      const MarkerPattern& pattern,
                                      const MarkerPlacement& start,
                                      double farthest_px);

/// Size of a marker that lies so: the square root of its outer square's area [px].
[[nodiscard]] double placed_size_px(const MarkerPlacement& placement);

}  // namespace twang
