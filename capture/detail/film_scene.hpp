// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/film_camera.hpp"
#include "capture/marker_pattern.hpp"
#include "capture/render_film.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <array>
#include <vector>

namespace twang::detail {

/// Side of the white paper a marker is printed on, over the marker's size [-].
inline constexpr double kPaperSide = 1.5;

/// A rectangle of pixels, last column and row excluded.
struct PixelBox {
  int x0 = 0;
  int y0 = 0;
  int x1 = 0;
  int y1 = 0;

  [[nodiscard]] bool empty() const { return x1 <= x0 || y1 <= y0; }
  /// Smallest box around both; an empty one adds nothing.
  [[nodiscard]] PixelBox united(const PixelBox& other) const;
};

/// A grey picture in linear light, 0 black to 255 white, rows from the top.
struct Canvas {
  int width = 0;
  int height = 0;
  std::vector<float> light;  ///< (height x width)

  Canvas(int width_px, int height_px);
  [[nodiscard]] float* row(int y) { return light.data() + static_cast<std::ptrdiff_t>(y) * width; }
  [[nodiscard]] const float* row(int y) const {
    return light.data() + static_cast<std::ptrdiff_t>(y) * width;
  }
};

/// A face of the part as seen [px].
using ProjectedFace = std::array<Eigen::Vector2d, 4>;

/// A marker as seen: its centre and the affine map to its pattern's coordinates.
struct ProjectedMarker {
  MarkerPattern pattern;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d pattern_from_px =
      Eigen::Matrix2d::Identity();  ///< offset from the centre to pattern coordinates [1/px]
};

[[nodiscard]] ProjectedMarker project_marker(const FilmCamera& camera,
                                             const MarkerPattern& pattern,
                                             double size_m,
                                             const MarkerPose& pose,
                                             const Eigen::Vector2d& shift_px);

/// Pixels that a marker's paper touches, within the canvas.
[[nodiscard]] PixelBox box_of(const ProjectedMarker& marker, const Canvas& canvas);
/// Pixels that the faces touch, within the canvas.
[[nodiscard]] PixelBox box_of(const std::vector<ProjectedFace>& faces, const Canvas& canvas);

/// The bench: light grey, with a gradient and a faint smooth texture that moves with the camera.
void paint_bench(Canvas& canvas, const FilmCamera& camera, const Eigen::Vector2d& shift_px);

/// Fills the union of the faces, anti-aliased; `mask` is scratch space kept between calls.
void paint_silhouette(Canvas& canvas,
                      const std::vector<ProjectedFace>& faces,
                      std::vector<std::uint8_t>& mask);

/// A marker in ink on a square of white paper, half as large again; area-averaged over each pixel.
///
/// A lens blurs before the sensor samples; a Gaussian over finished pixels comes too late and lets
/// edges wander with the place of the pixels. So the first pixel's width of a lens's blur is
/// painted in.
/// @param soft  spread evenly over a pixel's width first: of the lens's blur that takes the
/// variance
///              `kSoftVariance_px2`
void paint_marker(Canvas& canvas, const ProjectedMarker& marker, bool soft = false);
inline constexpr double kSoftVariance_px2 = 1.0 / 12.0;

/// Gaussian blur in place; sigma 0 leaves the canvas as it is.
void defocus(Canvas& canvas, double sigma_px);

}  // namespace twang::detail
