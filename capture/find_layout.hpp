// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/fit_marker.hpp"
#include "capture/plane_map.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace twang {

/// A marker's rest position in the coordinates of the picture's plane: along image_right and along
/// image_down [m].
[[nodiscard]] Eigen::Vector2d plane_position(const Camera& camera, const Eigen::Vector3d& position);

/// Where a rig's markers are in a picture.
struct Layout {
  std::vector<FittedMarker> markers;                  ///< in the rig's order
  Homography px_from_plane = Homography::Identity();  ///< rest plane -> picture: fixed markers
                                                      ///< decide, as far as they can [px]
  [[nodiscard]] Eigen::Vector2d to_px(const Eigen::Vector2d& plane) const {
    return map_point(px_from_plane, plane);
  }
};

/// What a picture shows of a rig's markers.
struct PartialLayout {
  std::vector<std::optional<FittedMarker>> markers;   ///< in the rig's order; absent: not seen
  Homography px_from_plane = Homography::Identity();  ///< rest plane -> picture [px]
  int num_found = 0;
  /// Whether those that were found leave no doubt about which is which and where the rest would be.
  bool usable = false;
  /// All markers have a place, but which is which cannot be told, or a stated start has no marker:
  /// another picture will hardly be better.
  bool hopeless = false;
  std::string problem;  ///< why not all were found, one sentence; empty if all were
};

/// Finds all markers of a rig in a picture.
///
/// Everything that looks like one of the markers' kinds is a candidate; the assignment of
/// candidates to markers is the one under which the picture is the rig's layout, seen at any scale
/// and turned by up to 30 degrees. Moving markers may stand away from rest by the rig's release, or
/// by a part of the layout's extent.
///
/// @param start_px  where a marker stands, by id; overrules the search for that marker, which is
///                  then sought near that place alone [px]
/// @param film      name of the picture in messages
/// @throws InputError if a marker is of a kind that cannot be found in a picture, is not found, or
/// the layout fits several places about equally well; if `start_px` names no marker or a place
/// outside the picture or with no marker near it
[[nodiscard]] Layout find_layout(const LumaFrame& frame,
                                 const Rig& rig,
                                 const std::map<std::string, Eigen::Vector2d>& start_px = {},
                                 const std::string& film = "the picture");

/// The same, content with a part of the markers: others may be hidden.
///
/// It is usable if at least half of the markers were found, three or all the fixed ones among them,
/// and no other assignment of places is about as good.
///
/// @param picture  the picture's name in the sentence about the problem ("the first frame")
/// @throws InputError as `find_layout` for what no picture can mend
[[nodiscard]] PartialLayout search_layout(const LumaFrame& frame,
                                          const Rig& rig,
                                          const std::map<std::string, Eigen::Vector2d>& start_px,
                                          const std::string& film,
                                          const std::string& picture);

}  // namespace twang
