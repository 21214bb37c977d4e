// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/plane_map.hpp"
#include "capture/track_markers.hpp"
#include "core/trace.hpp"
#include "rigs/rig.hpp"

#include <vector>

namespace twang::detail {

/// The trace that a trace file holds, from tracks in pixels: positions of each marker in the rig
/// frame along the axes the image shows, their sigmas, with a readout time each marker's time
/// offset, and the observable. Rows of doubled frames are nan.
///
/// The third coordinate, which the image does not show, is taken as at rest.
[[nodiscard]] Trace trace_of_tracks(const Rig& rig,
                                    const std::vector<MarkerTrack>& tracks,
                                    const PlaneMap& map,
                                    const std::vector<double>& time_s,
                                    const std::vector<bool>& doubled,
                                    int height_px);

}  // namespace twang::detail
