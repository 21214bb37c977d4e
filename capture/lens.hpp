// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <array>
#include <filesystem>

namespace twang {

enum class LensModel {
  Polynomial,  ///< Brown-Conrady with rational radial, thin-prism and tilt terms
  Fisheye      ///< Kannala-Brandt, equidistant
};

/// How a lens bends the picture that a pinhole camera would take, as calibrated.
///
/// Both pictures share their pixels: a point at `ideal` in the pinhole picture is seen at `seen`,
///
///     (x, y) = ((ideal.x - c_x) / f_x, (ideal.y - c_y) / f_y),   seen = (f_x x', f_y y') + c
///
/// with, in the polynomial model and r² = x² + y²  [Brown 1966; terms and order of the
/// coefficients k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 τx τy as in OpenCV's calib3d]
///
///     g  = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)
///     x' = g x + 2 p1 x y + p2 (r² + 2 x²) + s1 r² + s2 r⁴
///     y' = g y + p1 (r² + 2 y²) + 2 p2 x y + s3 r² + s4 r⁴
///
/// and then the projection onto a sensor turned by τx, τy; in the fisheye model [Kannala & Brandt
/// 2006] with θ = atan r
///
///     (x', y') = (x, y) θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) / r
///
/// Pixel (0, 0) is the centre of the upper left one here and in OpenCV alike.
struct Lens {
  LensModel model = LensModel::Polynomial;
  int width_px = 0;  ///< of the pictures it was calibrated with, as shown [px]
  int height_px = 0;
  Eigen::Vector2d focal_px = Eigen::Vector2d::Zero();   ///< f_x, f_y > 0 [px]
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< c_x, c_y [px]
  std::array<double, 14> coefficients{};                ///< in OpenCV's order; 0 where absent [-]

  /// Where a point of the pinhole picture is seen [px].
  [[nodiscard]] Eigen::Vector2d distorted(const Eigen::Vector2d& ideal) const;
  /// d seen / d ideal [-].
  [[nodiscard]] Eigen::Matrix2d distortion_jacobian(const Eigen::Vector2d& ideal) const;
  /// Where the pinhole picture has what is seen at a pixel: Newton's method on `distorted`; nan if
  /// the lens shows nothing there.
  [[nodiscard]] Eigen::Vector2d undistorted(const Eigen::Vector2d& seen) const;
};

/// Reads a camera calibration as OpenCV's FileStorage writes it (YAML, XML or JSON) or as ROS
/// `camera_info` (YAML).
///
/// Read are `image_width`, `image_height`, `camera_matrix`, `distortion_coefficients` (or
/// `dist_coeffs`; 4, 5, 8, 12 or 14 entries), and, for fisheye lenses with 4, `distortion_model`
/// (`equidistant` or `fisheye`) or `fisheye_model`.
///
/// @throws InputError if the file does not exist or is none, a value is missing, not finite or out
/// of range, or the lens folds the picture over within its borders
[[nodiscard]] Lens read_lens(const std::filesystem::path& file);

/// The lens for a film of the same field of view and another number of pixels.
/// @throws InputError if the film's sides are not in the calibration's proportion, to a pixel
[[nodiscard]] Lens lens_for_size(const Lens& lens, int width_px, int height_px);

}  // namespace twang
