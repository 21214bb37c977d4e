// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/doubled_frames.hpp"
#include "capture/track_markers.hpp"

#include <vector>

namespace twang::detail {

/// Which frames repeat the one before: those whose picture says so, and of those whose picture
/// leaves it open the ones where a marker should have moved and did not.
///
/// Where a marker should have been follows from the frames around: about frame c, in frames t from
/// it, its path is a vibration with slowly changing size and phase about a slowly moving rest,
///
///     y(t) = p + q t + r t² + (a + b t) cos ω t + (c + d t) sin ω t,   or a cubic,
///
/// by least squares without frame c and others that may be repeats; ω is the one that fits best.
/// A frame taken symmetrically about a turning point stands where this puts it; a repeat that took
/// a frame's place does not. A repeat that was put in between two frames shifts all that follow:
/// the fit is tried with such frames taken out of time, too.
///
/// Where nothing moves by a few standard errors, nothing is called a repeat. Nor is a frame that a
/// coder may have left as it was: where it spends little, before a picture coded by itself, or
/// where the marker should have moved by less than 0.22 px and the coder does not speak for a
/// repeat. Pictures around that are alike say how far such ones are off. A lamp's ripple is told as
/// a marker's motion is, up to the film's ends, and clears a frame in which it went on.
/// @param likeness  one a frame
/// @param light     mean of each picture [grey levels]: a lamp's ripple tells the time as a marker
///                  does; empty if not known
/// @param evidence  see `repeat_evidence`; empty if not known
[[nodiscard]] std::vector<bool> find_repeats(const std::vector<MarkerTrack>& tracks,
                                             const std::vector<Likeness>& likeness,
                                             const std::vector<double>& light = {},
                                             const std::vector<double>& evidence = {});

}  // namespace twang::detail
