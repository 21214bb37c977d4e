// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/film_camera.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace twang::detail {
namespace {

constexpr double kDistanceInWidths = 8.0;
// The extent in pixels is nearly proportional to the scale; a few corrections settle it.
constexpr int kFitSteps = 8;

}  // namespace

FilmCamera::FilmCamera(const Camera& camera,
                       const std::vector<Eigen::Vector3d>& points,
                       const ViewOptions& options)
    : m_middle_px(0.5 * (options.width_px - 1), 0.5 * (options.height_px - 1)),
      m_width_px(options.width_px),
      m_sin(std::sin(options.tilt_rad)),
      m_cos(std::cos(options.tilt_rad)) {
  if (options.lens) m_lens = lens_for_size(*options.lens, options.width_px, options.height_px);
  m_axes.row(0) = camera.image_right;
  m_axes.row(1) = camera.image_down;
  m_roll << std::cos(options.roll_rad), -std::sin(options.roll_rad), std::sin(options.roll_rad),
      std::cos(options.roll_rad);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high = -low;
  for (const Eigen::Vector3d& point : points) {
    low = low.cwiseMin(m_axes * point);
    high = high.cwiseMax(m_axes * point);
  }
  m_centre = m_axes.transpose() * (0.5 * (low + high));

  const Eigen::Vector2d room =
      (m_middle_px.array() - options.margin_px).max(0.25 * m_middle_px.array());
  m_scale = room.x() / std::max(1e-9, (high - low).norm());
  for (int step = 0; step < kFitSteps; ++step) {
    double fill = 0.0;  // 1: just fits
    for (const Eigen::Vector3d& point : points) {
      const Eigen::Vector2d offset = (pixel_from_rig(point) - m_middle_px).cwiseAbs();
      fill = std::max({fill, offset.x() / room.x(), offset.y() / room.y()});
    }
    if (fill > 0.0) m_scale /= fill;
  }
}

Eigen::Vector2d FilmCamera::plane_from_rig(const Eigen::Vector3d& point) const {
  return m_axes * (point - m_centre);
}

Eigen::Vector2d FilmCamera::project(const Eigen::Vector2d& plane) const {
  const double distance = kDistanceInWidths * m_width_px / m_scale;
  const double depth = distance + plane.x() * m_sin;
  return m_scale * distance / depth * Eigen::Vector2d(plane.x() * m_cos, plane.y());
}

Eigen::Vector2d FilmCamera::pixel_from_rig(const Eigen::Vector3d& point,
                                           const Eigen::Vector2d& shift_px) const {
  const Eigen::Vector2d ideal = m_middle_px + m_roll * project(plane_from_rig(point)) + shift_px;
  return m_lens ? m_lens->distorted(ideal) : ideal;
}

Eigen::Matrix2d FilmCamera::jacobian(const Eigen::Vector3d& point,
                                     const Eigen::Vector2d& shift_px) const {
  const Eigen::Vector2d plane = plane_from_rig(point);
  const double distance = kDistanceInWidths * m_width_px / m_scale;
  const double depth = distance + plane.x() * m_sin;
  const double zoom = m_scale * distance / depth;
  Eigen::Matrix2d J;
  J << zoom * m_cos * distance / depth, 0.0, -zoom * plane.y() * m_sin / depth, zoom;
  J = m_roll * J;
  if (!m_lens) return J;
  return m_lens->distortion_jacobian(m_middle_px + m_roll * project(plane) + shift_px) * J;
}

Eigen::Vector2d FilmCamera::plane_from_pixel(const Eigen::Vector2d& pixel,
                                             const Eigen::Vector2d& shift_px) const {
  const Eigen::Vector2d ideal = (m_lens ? m_lens->undistorted(pixel) : pixel) - shift_px;
  const Eigen::Vector2d seen = m_roll.transpose() * (ideal - m_middle_px) / m_scale;
  const double distance = kDistanceInWidths * m_width_px / m_scale;
  const double u = seen.x() * distance / (distance * m_cos - seen.x() * m_sin);
  return {u, seen.y() * (distance + u * m_sin) / distance};
}

}  // namespace twang::detail
