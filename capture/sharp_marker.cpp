// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/sharp_marker.hpp"

#include "capture/detail/spline_picture.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>

namespace twang {
namespace {

constexpr double kSamplesPerPixel = 8.0;
// Samples a side at most, for markers over about 60 px; their edges are then still resolved.
constexpr int kMostSamples = 640;
// The sampled square reaches this far beyond the marker: what is left of the blur there is nil.
constexpr double kWidestBlur_px = 4.0;
constexpr double kReachInSigmas = 3.5;
constexpr double kCutOutSmoothing_px = 0.7;

}  // namespace

SharpMarker::SharpMarker(const MarkerPattern& pattern,
                         double size_px,
                         double widest_blur_px,
                         bool cut_out)
    : m_pattern(pattern),
      m_size_px(size_px),
      m_widest_blur_px(std::max(kWidestBlur_px, widest_blur_px)),
      m_cut_out(cut_out) {
  const double half_width = 0.5 + (1.0 + kReachInSigmas * m_widest_blur_px) / size_px;
  const double wished = 2.0 * half_width * size_px * kSamplesPerPixel;
  m_side = std::min(static_cast<int>(std::ceil(0.5 * wished)) * 2, kMostSamples) + 1;
  m_samples_per_unit = (m_side - 1) / (2.0 * half_width);
  m_samples.assign(static_cast<std::size_t>(m_side) * static_cast<std::size_t>(m_side), 1.0F);
}

SharpMarker::SharpMarker(const MarkerPattern& pattern, double size_px, double widest_blur_px)
    : SharpMarker(pattern, size_px, widest_blur_px, false) {
  draw();
}

bool SharpMarker::is_mirrored() const {
  return m_pattern.kind() == MarkerKind::Cross || m_pattern.kind() == MarkerKind::Dot ||
         m_pattern.kind() == MarkerKind::Ring;
}

/// The pattern averaged over a pixel at every sample that is not surely paper.
void SharpMarker::draw() {
  const double reach = m_pattern.kind() == MarkerKind::Patch ? half_width() : 0.5 + 0.5 / m_size_px;
  const int first = std::max(0, static_cast<int>((half_width() - reach) * m_samples_per_unit));
  const bool mirrored = is_mirrored();
  const int last = mirrored ? m_side / 2 : m_side - 1 - first;
  const auto at = [&](int row, int column) -> float& {
    return m_samples[static_cast<std::size_t>(row * m_side + column)];
  };
  for (int row = first; row <= last; ++row) {
    const double v = row / m_samples_per_unit - half_width();
    for (int column = first; column <= last; ++column) {
      const double u = column / m_samples_per_unit - half_width();
      const auto value = static_cast<float>(m_pattern.averaged(u, v, 1.0 / m_size_px));
      at(row, column) = value;
      if (!mirrored) continue;
      const int below = m_side - 1 - row;
      const int beside = m_side - 1 - column;
      at(row, beside) = at(below, column) = at(below, beside) = value;
    }
  }
}

SharpMarker SharpMarker::cut_out(const MarkerPattern& pattern,
                                 const LumaFrame& frame,
                                 const Eigen::Vector2d& position_px,
                                 const Eigen::Matrix2d& px_from_pattern) {
  const double size_px = std::sqrt(std::abs(px_from_pattern.determinant()));
  SharpMarker cut(pattern, size_px, 0.0, true);
  const Eigen::Vector2d reach = cut.half_width() * px_from_pattern.cwiseAbs().rowwise().sum();
  const detail::SplinePicture picture(frame, position_px, reach, kCutOutSmoothing_px);
  float low = std::numeric_limits<float>::max();
  float high = std::numeric_limits<float>::lowest();
  std::size_t i = 0;
  for (int row = 0; row < cut.m_side; ++row) {
    const double v = row / cut.m_samples_per_unit - cut.half_width();
    for (int column = 0; column < cut.m_side; ++column) {
      const double u = column / cut.m_samples_per_unit - cut.half_width();
      const auto grey =
          static_cast<float>(picture.at(position_px + px_from_pattern * Eigen::Vector2d(u, v)));
      cut.m_samples[i++] = grey;
      if (std::max(std::abs(u), std::abs(v)) > 0.5) continue;
      low = std::min(low, grey);
      high = std::max(high, grey);
    }
  }
  const float scale = high > low ? 1.0F / (high - low) : 1.0F;
  for (float& value : cut.m_samples) value = scale * (value - low);
  return cut;
}

}  // namespace twang
