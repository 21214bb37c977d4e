// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/layout_marker.hpp"
#include "capture/detail/marker_candidates.hpp"
#include "capture/plane_map.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang::detail {

/// Which candidate each marker is.
struct Constellation {
  std::vector<int> candidate;                         ///< one a marker; -1: none found
  Homography px_from_plane = Homography::Identity();  ///< rest plane -> picture [px]
  double cost = 0.0;    ///< sum of squared deviations in sigmas, a fixed price for each missing one
  int num_matched = 0;  ///< markers with a candidate
};

/// Best assignment and the ones that are about as good.
struct ConstellationMatch {
  std::vector<Constellation> about_as_good;  ///< best first; empty if nothing fits at all
};

/// Finds the assignment of candidates to markers under which the picture is the rig's layout seen
/// at any scale and at a slant, turned by no more than `most_turn_rad`, sizes included.
///
/// Hypotheses are similarities through pairs (fixed markers first: they are at rest); those under
/// which enough of the others have a candidate are refined to a homography held to a similarity by
/// what tilt and perspective are to be expected, and judged again: by the places, the sizes, the
/// scores, and by how much neighbouring moving markers have moved against each other. How far
/// moving markers have gone at all is fitted, so that equal dots at rest are not taken to have
/// changed places.
///
/// Cost: O(candidates²) hypotheses of O(markers x candidates), most of them given up early.
[[nodiscard]] ConstellationMatch match_constellation(const std::vector<LayoutMarker>& markers,
                                                     const std::vector<MarkerCandidate>& candidates,
                                                     double most_turn_rad);

}  // namespace twang::detail
