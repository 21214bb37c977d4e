// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/align_marker.hpp"

#include <cstddef>
#include <vector>

namespace twang::detail {

/// A tag in a picture.
struct FoundTag {
  std::size_t pattern = 0;    ///< which of those that were sought
  MarkerPlacement placement;  ///< to about half a pixel, the turn included
};

/// Finds tags (ArUco, AprilTag) at any size from about 16 pixels and in any turn, in the whole
/// picture. Tags that are not sought are passed over, and so is what cannot be read with certainty.
///
/// The picture is searched as it is and, for what is still missing, at twice its size. Cost: a few
/// tenths of a second for a picture of two million pixels.
///
/// @param patterns  what is sought; what is no tag is not found
[[nodiscard]] std::vector<FoundTag> find_tags(const LumaFrame& frame,
                                              const std::vector<MarkerPattern>& patterns);

}  // namespace twang::detail
