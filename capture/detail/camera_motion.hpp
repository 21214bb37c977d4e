// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/plane_fit.hpp"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace twang::detail {

/// A fixed marker over a film.
struct FixedMarker {
  const std::vector<Eigen::Vector2d>* position_px = nullptr;  ///< one a frame, nan where lost [px]
  const std::vector<double>* sigma_px = nullptr;              ///< one a frame [px]
};

/// How the camera moved, by what the fixed markers seem to do.
struct CameraMotion {
  std::optional<MapKind> kind;              ///< absent: it stood still
  std::vector<Eigen::Vector2d> mean_px;     ///< each marker in the mean picture [px]
  std::vector<MapFit> mean_from_frame;      ///< one a frame; nan where none is seen. Empty: still
  std::vector<std::vector<bool>> left_out;  ///< [marker][frame]: seen, but not where the bench is
  double scatter_px = 0.0;                  ///< rms of a coordinate before [px] ...
  double left_px = 0.0;                     ///< ... and after the motion is taken out [px]
  double widening = 1.0;  ///< of the markers' sigmas, by what their residuals say, >= 1 [-]

  [[nodiscard]] bool still() const { return !kind.has_value(); }
  /// Number of frames in which a marker was left out.
  [[nodiscard]] int frames_left_out(std::size_t marker) const;
};

/// Finds the camera's motion from the fixed markers' tracks.
///
/// The maps tried are none, the shift (one marker) or similarity of each frame, and the homography
/// of each frame (four or more). More freedom is granted only where it lowers the error: Mallows'
/// C_p, the gain in chi-square over the parameters it costs, in units of the residuals' own noise
/// where that exceeds the stated one (residuals of a motion that leaves out a tenth of what is seen
/// are not noise). A camera that moves moves all its markers: if one stands still, it is the others
/// that were touched.
///
/// A marker that is away from its first place by more than its noise and `kBump_px` while the
/// others agree is left out of the frames in which it is. Its first place is the one that counts: a
/// marker that is pushed in the course of a film was measured before.
///
/// @param markers  at least one, each seen at least once
[[nodiscard]] CameraMotion find_camera_motion(const std::vector<FixedMarker>& markers);

/// Below this a displacement of a fixed marker against the others is not called one [px].
inline constexpr double kBump_px = 0.1;

}  // namespace twang::detail
