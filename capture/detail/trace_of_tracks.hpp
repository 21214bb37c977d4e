// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/lens.hpp"
#include "capture/plane_map.hpp"
#include "capture/track_markers.hpp"
#include "core/trace.hpp"
#include "rigs/rig.hpp"

#include <vector>

namespace twang::detail {

/// The tracks as the pinhole picture would show them: positions without the lens's distortion,
/// sigmas by its local scale.
[[nodiscard]] std::vector<MarkerTrack> straightened(const std::vector<MarkerTrack>& tracks,
                                                    const Lens& lens);

/// What a trace is made from.
struct TrackedFilm {
  const std::vector<MarkerTrack>& tracks;    ///< as seen in the picture
  const std::vector<MarkerTrack>& straight;  ///< without the lens's distortion; may be the same
  const PlaneMap& map;                       ///< from the straight picture
  const std::vector<double>& time_s;
  const std::vector<bool>& doubled;
  int height_px = 0;  ///< of the picture as seen [px]
};

/// The trace that a trace file holds, from tracks in pixels: positions of each marker in the rig
/// frame along the axes the image shows, their sigmas, with a readout time each marker's time
/// offset, and the observable. Rows of doubled frames are nan.
///
/// The third coordinate, which the image does not show, is taken as at rest. A moving marker's
/// sigma is that of its reading and of its frame's own plane map, that of a fixed one its reading's
/// alone.
///
/// With a readout time markers in different rows are seen at different times. The observable is
/// that at the mean of its markers' times, `observable.time_offset_s` after the frame's: each
/// marker's position is brought there by a polynomial through its neighbouring samples at their own
/// times (`kReadoutNeighbours` of them, fewer next to gaps; none if it has no neighbours). The
/// fixed markers' own times are not told apart, see `map_plane`.
[[nodiscard]] Trace trace_of_tracks(const Rig& rig, const TrackedFilm& film);

/// Samples that a position between two samples is interpolated from: at 0.4 of the frame rate an
/// offset of a tenth of a frame is then good to 1 % of itself.
inline constexpr int kReadoutNeighbours = 6;

}  // namespace twang::detail
