// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/follow_marker.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace twang::detail {

/// A thing that looks like a marker and is none of the rig's.
struct Stranger {
  std::size_t like;    ///< the marker
  Eigen::Vector2d px;  ///< where it is in the first picture
};

/// Those near the markers seen in the first picture, who are told to keep off them.
/// @param first  where they were found
[[nodiscard]] std::vector<Stranger> find_strangers(const LumaFrame& frame,
                                                   std::vector<MarkerFollower>& followers,
                                                   const std::vector<MarkerSample>& first);

}  // namespace twang::detail
