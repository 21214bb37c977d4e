// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/plane_fit.hpp"
#include "core/constants.hpp"
#include "core/note.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <string>
#include <vector>

namespace twang {

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
  double residual_px = 0.0;  ///< rms of the fixed markers about it; 0 where the map takes each to
                             ///< its place whatever it is (two of a similarity, four of a
                             ///< homography) [px]
  double mm_per_px = 0.0;    ///< scale in the middle of the markers' rest positions [mm/px]
  std::vector<Note> notes;   ///< how it was found, one sentence each
  double residual_mm = 0.0;  ///< the same as residual_px in the plane [mm]
  double scale_sigma_rel = kNaN;  ///< one sigma of the scale in the middle of the markers, by how
                                  ///< well their places agree: common to all frames, and in no
                                  ///< sample's sigma; nan where nothing tells [-]
  std::vector<std::vector<double>>
      noise_m;  ///< [marker][frame]: one sigma of a coordinate that the frame's own map adds to
                ///< what is seen at a moving marker; 0 for a fixed one. Empty: one map for all [m]
  std::vector<int> frames_left_out;  ///< one a marker: frames in which a fixed one was not believed

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
/// One map serves the whole film unless the fixed markers say that the camera moved. Then its
/// motion is followed: by a shift (one fixed marker) or a similarity of the picture in each frame,
/// and by a homography of each frame if a similarity does not explain four markers or more. More
/// freedom is granted where what it takes out is more than the noise that a map of each frame adds.
/// A fixed marker that moves against the others, or is misread, takes no part while it does.
///
/// With a rolling shutter each row is read at its own time; a map mixes those of the fixed markers,
/// which leaves (speed of the shake) x (difference of their times): nothing beside the shake
/// itself.
///
/// @param markers  in the rig's order, at least one
/// @throws InputError if fixed markers that should span the plane do not, or a fixed marker is
/// never seen
[[nodiscard]] PlaneMap map_plane(const std::vector<PlaneMarker>& markers);

/// Where a marker settles: the mean of its last positions under a window that suppresses what is
/// left of the vibration; nan if it is never seen there. [px]
[[nodiscard]] Eigen::Vector2d settled_position(const std::vector<Eigen::Vector2d>& positions);

}  // namespace twang
