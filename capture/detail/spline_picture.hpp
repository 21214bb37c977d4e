// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/video_reader.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang::detail {

/// A part of a picture as a smooth function of place: smoothed by a Gaussian and interpolated by
/// cubic B-splines [Unser 1999].
///
/// The smoothing matters for what is aligned with it. Unsmoothed, interpolated noise is strongest
/// at whole pixels and weakest between them, and alignment, which looks for the least difference,
/// is drawn to half pixels: by 0.02 px for a patch of 40 px of moderate contrast in noise of 2 grey
/// levels, by a tenth of that after smoothing. Being symmetric, the smoothing itself draws nowhere.
class SplinePicture {
 public:
  /// The picture around a place: `reach_px` to all sides, and cut to the picture. Beyond it the
  /// pixels at the edge go on.
  SplinePicture(const LumaFrame& frame,
                const Eigen::Vector2d& middle_px,
                const Eigen::Vector2d& reach_px,
                double smoothing_px);

  /// Grey level at a place in the picture's pixel coordinates.
  [[nodiscard]] double at(const Eigen::Vector2d& px) const;

 private:
  int m_x0 = 0, m_y0 = 0;  // of the part in the picture
  int m_width = 0, m_height = 0;
  std::vector<float> m_coefficients;  // (height x width)
};

}  // namespace twang::detail
