// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"
#include "capture/track_markers.hpp"
#include "rigs/rig.hpp"

#include <string>

namespace twang {

/// One page that shows whether a tracked film can be trusted: the first frame with the layout
/// found, the observable, the time base, the fixed markers' residual, and for each marker its path
/// over time, its sigma, its noise floor and where it was lost.
///
/// @param film  name of the film, for the title
/// @return      colour, 1600 x 1130 px (A4 landscape)
[[nodiscard]] Image draw_contact_sheet(const Rig& rig,
                                       const std::string& film,
                                       const TrackResult& result);

}  // namespace twang
