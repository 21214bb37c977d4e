// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"
#include "capture/track_markers.hpp"
#include "core/progress.hpp"

#include <filesystem>
#include <vector>

namespace twang {

/// What is drawn over a film.
struct TrackDrawing {
  std::vector<MarkerTrack> tracks;
  std::vector<double> size_px;  ///< of each marker [px]
  std::vector<bool> doubled;    ///< one a frame: repeats the one before
};

/// A grey picture in colour, with the markers as found in frame `frame` circled and named and their
/// whole paths drawn.
[[nodiscard]] Image draw_tracks(const Image& grey, const TrackDrawing& drawing, std::size_t frame);

/// Writes a film with the tracks drawn in: a crosshair and a name on each marker, its recent path,
/// and where a marker is lost that it is. The file appears whole or not at all.
///
/// @param fps  of the film written: slow enough to be watched [1/s]
/// @throws InputError if `video` cannot be read or `overlay` cannot be written; Cancelled
void write_overlay(const std::filesystem::path& video,
                   const std::filesystem::path& overlay,
                   const TrackDrawing& drawing,
                   double fps,
                   const ProgressCallback& progress = {});

}  // namespace twang
