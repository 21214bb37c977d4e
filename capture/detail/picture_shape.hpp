// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/track_markers.hpp"
#include "capture/video_reader.hpp"
#include "core/note.hpp"

#include <vector>

namespace twang::detail {

/// Tracks in square pixels, as high as the picture's: x times their width over their height; a
/// sigma, that of either coordinate, goes with the root of it.
void make_square(std::vector<MarkerTrack>& tracks, double pixel_aspect);

/// What is unusual about a film's pictures: pixels that are not square, rows of two moments.
[[nodiscard]] std::vector<Note> notes_on_pictures(const VideoInfo& info);

}  // namespace twang::detail
