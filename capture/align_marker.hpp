// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"
#include "capture/marker_template.hpp"
#include "capture/video_reader.hpp"

#include <Eigen/Core>

#include <optional>

namespace twang {

/// Where and how a marker lies in a picture.
struct MarkerPlacement {
  Eigen::Vector2d position_px = Eigen::Vector2d::Zero();  ///< of its centre [px]
  Eigen::Matrix2d px_from_pattern =
      Eigen::Matrix2d::Identity();  ///< size, turn and slant: an offset in units of the marker's
                                    ///< size to one in the picture [px]
  Eigen::Vector2d motion_px =
      Eigen::Vector2d::Zero();  ///< straight path during the exposure (motion blur) [px]
};

/// An upright marker of that size, turned anticlockwise as seen.
[[nodiscard]] MarkerPlacement upright_marker(const Eigen::Vector2d& position_px,
                                             double size_px,
                                             double turn_rad = 0.0);

/// What is left free when a marker is aligned; position, contrast, brightness and a linear shading
/// of the paper always are.
struct AlignOptions {
  bool fit_turn = true;      ///< only where the pattern shows it
  bool fit_shape = false;    ///< size and slant too (then the turn is part of it)
  bool fit_motion = false;   ///< length of the motion blur along `motion_px`, which must not be 0
  double farthest_px = 1e9;  ///< gives up farther than this from the start [px]
  std::optional<Eigen::Vector4d> light =
      {};  ///< o, g, g_x, g_y to start from, of a picture alike; absent: found first [grey levels]
};

/// A marker found to a fraction of a pixel.
struct MarkerAlignment {
  MarkerPlacement placement;
  bool converged = false;  ///< false: the rest means nothing
  double turn_rad = 0.0;   ///< from the start, anticlockwise as seen [rad]
  double sigma_px = 0.0;   ///< one standard deviation of one coordinate, see `align_marker` [px]
  double score = 0.0;      ///< correlation of picture and model over the marker, -1..1 [-]
  double contrast = 0.0;   ///< paper over ink [grey levels]
  Eigen::Vector4d light = Eigen::Vector4d::Zero();  ///< o, g, g_x, g_y [grey levels]
  double residual = 0.0;  ///< rms difference of picture and model [grey levels]
};

/// Finds a marker to a fraction of a pixel by Gauss-Newton on its known ideal picture.
///
///     I(p) ≈ o + (g + g_x u + g_y v) T(u, v)        (u, v) = px_from_pattern⁻¹ (p − position)
///
/// in the least-squares sense over the marker and a narrow rim of paper, T averaged along the path
/// of motion. The model is evaluated at the picture's own pixels, so nothing is interpolated there
/// and the pixels' noise stays independent. Differences between model and picture that are
/// symmetric about the marker's centre (defocus, motion blur, compression) do not bias it.
///
/// The sigma is that of the normal matrix and the residual's variance, times the factor by which
/// neighbouring residuals' correlation (compression, misfit) widens it, with a floor of
/// `kSigmaFloor_px`.
///
/// @param start  within about a quarter of the marker's size of the truth
[[nodiscard]] MarkerAlignment align_marker(const LumaFrame& frame,
                                           const MarkerTemplate& marker,
                                           const MarkerPlacement& start,
                                           const AlignOptions& options = {});

/// A sampled and compressed picture is never trusted below this, whatever its residual [px].
inline constexpr double kSigmaFloor_px = 0.0012;

/// A grey image as the frame it is; valid as long as the image.
[[nodiscard]] LumaFrame luma_view(const Image& grey);

}  // namespace twang
