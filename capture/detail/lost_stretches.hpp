// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/track_markers.hpp"
#include "core/note.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace twang::detail {

/// Notes that a marker is lost in a frame, the one after those noted before or any later one.
void note_lost(MarkerTrack& track, std::size_t frame, const std::string& because);

/// What a person is told of a marker's losses: a sentence for each of the first few stretches, then
/// a count; nothing for a marker that was never lost. A marker lost for good, or many times, is a
/// warning.
[[nodiscard]] std::vector<Note> notes_on_losses(const MarkerTrack& track);

}  // namespace twang::detail
