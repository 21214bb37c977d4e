// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/lens.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace twang::detail {

/// How a rendered film is viewed.
struct ViewOptions {
  int width_px = 640;
  int height_px = 360;
  double tilt_rad = 0.0;          ///< about the camera's vertical axis
  double roll_rad = 0.0;          ///< about the line of sight, clockwise in the picture
  double margin_px = 0.0;         ///< kept free around everything
  std::optional<Lens> lens = {};  ///< bends the picture; absent: a pinhole
};

/// The one map from the rig frame to pixels.
///
/// A point is projected along the line of sight onto the rig's image plane, (u, v) [m], and that
/// plane is seen by a pinhole camera at a distance D of eight picture widths, turned by the tilt θ:
///
///     x = s D u cos θ / (D + u sin θ),   y = s D v / (D + u sin θ)      [px from the centre]
///
/// then rolled, shifted as the camera is shaken, and bent by the lens, if there is one. Without
/// tilt and lens this is a similarity.
class FilmCamera {
 public:
  /// Chooses centre and scale s so that all `points` are in the picture.
  FilmCamera(const Camera& camera,
             const std::vector<Eigen::Vector3d>& points,
             const ViewOptions& options);

  /// @param shift_px  of the pinhole picture, by shake [px]
  [[nodiscard]] Eigen::Vector2d pixel_from_rig(const Eigen::Vector3d& point,
                                               const Eigen::Vector2d& shift_px) const;
  [[nodiscard]] Eigen::Vector2d pixel_from_rig(const Eigen::Vector3d& point) const {
    return pixel_from_rig(point, Eigen::Vector2d::Zero());
  }
  /// d pixel / d (u, v) at `point`, u along image right, v along image down [px/m].
  [[nodiscard]] Eigen::Matrix2d jacobian(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d& shift_px) const;
  [[nodiscard]] Eigen::Matrix2d jacobian(const Eigen::Vector3d& point) const {
    return jacobian(point, Eigen::Vector2d::Zero());
  }
  /// Where a pixel's ray meets the rig's image plane, (u, v) from the centre of view [m].
  [[nodiscard]] Eigen::Vector2d plane_from_pixel(const Eigen::Vector2d& pixel,
                                                 const Eigen::Vector2d& shift_px) const;
  [[nodiscard]] Eigen::Vector2d plane_from_pixel(const Eigen::Vector2d& pixel) const {
    return plane_from_pixel(pixel, Eigen::Vector2d::Zero());
  }
  /// s [px/m].
  [[nodiscard]] double scale_px_per_m() const { return m_scale; }

 private:
  [[nodiscard]] Eigen::Vector2d plane_from_rig(const Eigen::Vector3d& point) const;
  /// From the picture's centre, before the roll [px].
  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector2d& plane) const;

  std::optional<Lens> m_lens;
  Eigen::Matrix<double, 2, 3> m_axes;  // rows: image right, image down
  Eigen::Vector3d m_centre = Eigen::Vector3d::Zero();
  Eigen::Vector2d m_middle_px;
  Eigen::Matrix2d m_roll;
  double m_width_px = 0.0;
  double m_scale = 1.0;
  double m_sin = 0.0;
  double m_cos = 1.0;
};

}  // namespace twang::detail
