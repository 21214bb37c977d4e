// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/fit_marker.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <map>
#include <string>
#include <vector>

namespace twang {

/// A marker's rest position in the coordinates of the picture's plane: along image_right and along
/// image_down [m].
[[nodiscard]] Eigen::Vector2d plane_position(const Camera& camera, const Eigen::Vector3d& position);

/// Where a rig's markers are in a picture.
struct Layout {
  std::vector<FittedMarker> markers;  ///< in the rig's order
  Eigen::Matrix<double, 2, 3>
      px_from_plane;  ///< similarity from the rest plane to the picture: fixed markers decide, if
                      ///< there are two [px/m], [px]
  [[nodiscard]] Eigen::Vector2d to_px(const Eigen::Vector2d& plane) const {
    return px_from_plane * plane.homogeneous();
  }
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

}  // namespace twang
