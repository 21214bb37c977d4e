// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/marker_template.hpp"

#include <Eigen/Core>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

// Samples a pixel: bilinear interpolation then errs by under 0.5 % of the contrast.
constexpr double kSamplesPerPixel = 8.0;
// Samples a side at most, for markers over about 60 px; their edges are then still resolved.
constexpr int kMostSamples = 640;
// The sampled square reaches this far beyond the marker: what is left of the blur there is nil.
constexpr double kWidestBlur_px = 4.0;
constexpr double kReachInSigmas = 3.5;

}  // namespace

MarkerTemplate::MarkerTemplate(const MarkerPattern& pattern, double size_px, double blur_px)
    : m_pattern(pattern), m_size_px(size_px), m_has_turn(pattern.rotational_period_rad() > 0.0) {
  m_half_width = 0.5 + (1.0 + kReachInSigmas * std::max(kWidestBlur_px, blur_px)) / size_px;
  const double wished = 2.0 * m_half_width * size_px * kSamplesPerPixel;
  m_side = std::min(static_cast<int>(std::ceil(wished)), kMostSamples) + 1;
  m_samples_per_unit = (m_side - 1) / (2.0 * m_half_width);
  m_sharp.resize(static_cast<std::size_t>(m_side) * static_cast<std::size_t>(m_side));
  std::size_t i = 0;
  for (int row = 0; row < m_side; ++row) {
    const double v = row / m_samples_per_unit - m_half_width;
    for (int column = 0; column < m_side; ++column) {
      const double u = column / m_samples_per_unit - m_half_width;
      m_sharp[i++] = static_cast<float>(pattern.averaged(u, v, 1.0 / size_px));
    }
  }
  blur(blur_px);
}

MarkerTemplate MarkerTemplate::with_blur(double blur_px) const {
  if (blur_px > std::max(kWidestBlur_px, m_blur_px)) return {m_pattern, m_size_px, blur_px};
  MarkerTemplate other = *this;
  other.blur(blur_px);
  return other;
}

void MarkerTemplate::blur(double blur_px) {
  m_blur_px = blur_px;
  cv::Mat values(m_side, m_side, CV_32F, m_sharp.data());
  values = values.clone();
  if (blur_px > 0.0) {
    const double sigma = blur_px / m_size_px * m_samples_per_unit;
    cv::GaussianBlur(values, values, {0, 0}, sigma, sigma, cv::BORDER_REPLICATE);
  }
  const float per_step = static_cast<float>(0.5 * m_samples_per_unit);
  m_table.assign(m_sharp.size(), {1.0F, 0.0F, 0.0F, 0.0F});
  for (int row = 1; row + 1 < m_side; ++row) {
    for (int column = 1; column + 1 < m_side; ++column) {
      auto& cell = m_table[static_cast<std::size_t>(row * m_side + column)];
      cell[0] = values.at<float>(row, column);
      cell[1] = per_step * (values.at<float>(row, column + 1) - values.at<float>(row, column - 1));
      cell[2] = per_step * (values.at<float>(row + 1, column) - values.at<float>(row - 1, column));
    }
  }
}

MarkerTemplate::Sample MarkerTemplate::at(double u, double v) const {
  const double x = (u + m_half_width) * m_samples_per_unit;
  const double y = (v + m_half_width) * m_samples_per_unit;
  if (!(x >= 0.0 && y >= 0.0 && x < m_side - 1 && y < m_side - 1)) return {1.0, 0.0, 0.0};
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const float fx = static_cast<float>(x - column);
  const float fy = static_cast<float>(y - row);
  using Cell = Eigen::Map<const Eigen::Array4f>;
  const float* upper = m_table[static_cast<std::size_t>(row * m_side + column)].data();
  const float* lower = upper + 4 * m_side;
  const Eigen::Array4f above = (1.0F - fx) * Cell(upper) + fx * Cell(upper + 4);
  const Eigen::Array4f below = (1.0F - fx) * Cell(lower) + fx * Cell(lower + 4);
  const Eigen::Array4f mixed = (1.0F - fy) * above + fy * below;
  return {
      static_cast<double>(mixed[0]), static_cast<double>(mixed[1]), static_cast<double>(mixed[2])};
}

}  // namespace twang
