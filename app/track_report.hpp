// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/track_markers.hpp"
#include "rigs/rig.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

namespace twang::app {

/// What is said of a tracked film when it is done: its time base, its scale, a line a marker, the
/// notes; lines are separated by line ends.
[[nodiscard]] std::string track_summary_text(const Rig& rig, const TrackResult& result);

/// The same for programs: one entry of `films` in `twang-track/1`.
[[nodiscard]] nlohmann::ordered_json track_summary_json(const Rig& rig,
                                                        const std::filesystem::path& film,
                                                        const TrackResult& result);

/// Writes the contact sheet of a film as PNG.
void write_contact_sheet(const std::filesystem::path& target,
                         const Rig& rig,
                         const std::filesystem::path& film,
                         const TrackResult& result);

}  // namespace twang::app
