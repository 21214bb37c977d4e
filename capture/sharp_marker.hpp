// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/marker_pattern.hpp"
#include "capture/video_reader.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang {

/// A marker's ideal picture of one size, averaged over a pixel but not blurred, finely sampled on a
/// square: what templates of any blur are made of.
///
/// Coordinates are those of the pattern: in units of the outer size, centred, x right, y down.
class SharpMarker {
 public:
  /// @param size_px         outer size of the marker in the picture, > 0 [px]
  /// @param widest_blur_px  the square leaves room for blurs up to this one and up to 4 px [px]
  explicit SharpMarker(const MarkerPattern& pattern, double size_px, double widest_blur_px = 0.0);
  /// A marker as a picture shows it, see `MarkerTemplate::cut_out`.
  [[nodiscard]] static SharpMarker cut_out(const MarkerPattern& pattern,
                                           const LumaFrame& frame,
                                           const Eigen::Vector2d& position_px,
                                           const Eigen::Matrix2d& px_from_pattern);

  [[nodiscard]] const MarkerPattern& pattern() const { return m_pattern; }
  [[nodiscard]] double size_px() const { return m_size_px; }
  [[nodiscard]] bool is_cut_out() const { return m_cut_out; }
  /// Whether its left and right and its upper and lower halves are each other's mirror images.
  [[nodiscard]] bool is_mirrored() const;
  /// Widest blur that the square leaves room for [px].
  [[nodiscard]] double widest_blur_px() const { return m_widest_blur_px; }
  /// Samples along the square, odd.
  [[nodiscard]] int side() const { return m_side; }
  [[nodiscard]] double samples_per_unit() const { return m_samples_per_unit; }
  /// Half the square's side [units].
  [[nodiscard]] double half_width() const { return 0.5 * (m_side - 1) / m_samples_per_unit; }
  /// Row after row; 0 ink .. 1 paper.
  [[nodiscard]] const std::vector<float>& samples() const { return m_samples; }

 private:
  SharpMarker(const MarkerPattern& pattern, double size_px, double widest_blur_px, bool cut_out);
  void draw();

  MarkerPattern m_pattern;
  double m_size_px;
  double m_widest_blur_px;
  bool m_cut_out;
  int m_side = 0;
  double m_samples_per_unit = 0.0;  // [1/size]
  std::vector<float> m_samples;
};

}  // namespace twang
