// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

namespace twang {

/// A projective map of the plane, acting on (x, y, 1).
using Homography = Eigen::Matrix3d;

/// Where a map takes a point.
[[nodiscard]] Eigen::Vector2d map_point(const Homography& map, const Eigen::Vector2d& point);
/// Its derivative there: how a small offset is mapped.
[[nodiscard]] Eigen::Matrix2d map_jacobian(const Homography& map, const Eigen::Vector2d& point);

/// Points seen and where they are known to be.
struct PointPairs {
  std::vector<Eigen::Vector2d> from;
  std::vector<Eigen::Vector2d> to;
};

/// The similarity without reflection that takes `from` to `to` with the least squares.
/// @param pairs  two or more, not all at one place
[[nodiscard]] Homography fit_similarity_map(const PointPairs& pairs);

/// The homography that takes `from` to `to`: the direct linear transform on normalised points, then
/// Gauss-Newton on the squared distances in `to`.
/// @param pairs  four or more, no three of the first four on a line
/// @throws InputError if the points lie on a line and leave the map undetermined
[[nodiscard]] Homography fit_homography(const PointPairs& pairs);

/// A marker seen over the film, as the plane map needs it.
struct PlaneMarker {
  std::string id;
  bool fixed = false;
  Eigen::Vector2d rest = Eigen::Vector2d::Zero();  ///< in the rest plane (right, down) [m]
  double size_m = 0.0;                             ///< [m]
  double size_px = 0.0;                            ///< in the first frame [px]
  const std::vector<Eigen::Vector2d>* position_px = nullptr;  ///< one a frame, nan where lost [px]
  const std::vector<double>* sigma_px = nullptr;              ///< one a frame [px]
};

/// The map picture -> rest plane over a film.
struct PlaneMap {
  std::vector<Homography> plane_from_px;  ///< one a frame; one alone if the camera stood still [m]
  double residual_px = 0.0;        ///< rms of the fixed markers about it; 0 with under three [px]
  double mm_per_px = 0.0;          ///< scale in the middle of the markers' rest positions [mm/px]
  std::vector<std::string> notes;  ///< how it was found, one sentence each

  [[nodiscard]] const Homography& at(std::size_t frame) const {
    return plane_from_px.size() == 1 ? plane_from_px.front() : plane_from_px[frame];
  }
};

/// Finds the map picture -> rest plane from the markers' tracks.
///
/// Four fixed markers or more, not all about on a line, give a homography, else two or more a
/// similarity. With one fixed marker, or none, scale and turn come from where all markers settle at
/// the end of the film and their known rest positions, or with a single marker from its size, the
/// picture's axes being the rig's.
///
/// One map serves the whole film if the fixed markers' positions scatter about their means no more
/// than their sigmas say: an average over all frames is then better than each frame's own. Else the
/// camera's motion is followed: by a shift (one fixed marker) or a similarity of the picture in
/// each frame, and by a homography of each frame if a similarity does not explain four markers or
/// more.
///
/// @param markers  in the rig's order, at least one
/// @throws InputError if fixed markers that should span the plane do not, or a fixed marker is
/// never seen together with the others
[[nodiscard]] PlaneMap map_plane(const std::vector<PlaneMarker>& markers);

/// Where a marker settles: the mean of its last positions under a window that suppresses what is
/// left of the vibration; nan if it is never seen there. [px]
[[nodiscard]] Eigen::Vector2d settled_position(const std::vector<Eigen::Vector2d>& positions);

}  // namespace twang
