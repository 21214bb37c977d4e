// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/marker_template.hpp"

#include "capture/detail/spline_picture.hpp"

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace twang {
namespace {

// Samples a pixel; every other one is a cell. The expansion about the nearest then errs by under
// 0.1 % of the contrast.
constexpr double kSamplesPerPixel = 8.0;
constexpr int kSamplesPerCell = 2;
// Samples a side at most, for markers over about 60 px; their edges are then still resolved.
constexpr int kMostSamples = 640;
// The sampled square reaches this far beyond the marker: what is left of the blur there is nil.
constexpr double kWidestBlur_px = 4.0;
constexpr double kReachInSigmas = 3.5;
constexpr double kCutOutSmoothing_px = 0.7;

// Change from cell to cell below which a template does not change [-].
constexpr float kEven = 1e-5F;

using Cells = std::vector<std::array<float, detail::kCellFloats>>;

/// Writes into each cell how far from it no cell has a slope worth the name.
void mark_even(Cells& cells, int side) {
  cv::Mat even(side, side, CV_8UC1);
  for (int i = 0; i < side * side; ++i) {
    const auto& cell = cells[static_cast<std::size_t>(i)];
    even.data[i] = std::abs(cell[1]) + std::abs(cell[2]) < kEven ? 255 : 0;
  }
  cv::Mat distance;
  cv::distanceTransform(even, distance, cv::DIST_L2, cv::DIST_MASK_3);
  for (int i = 0; i < side * side; ++i) {
    // The transform errs by a twentieth.
    cells[static_cast<std::size_t>(i)][6] = 0.95F * distance.ptr<float>()[i] - 1.0F;
  }
}

/// Values and derivatives by the cell's index (differences of fourth order); beyond the square all
/// is paper.
Cells make_cells(const cv::Mat& values) {
  const int side = (values.rows - 1) / kSamplesPerCell + 1;
  Cells cells(static_cast<std::size_t>(side) * static_cast<std::size_t>(side),
              Cells::value_type{1.0F});
  constexpr float kPerStep = static_cast<float>(kSamplesPerCell);
  const auto slope = [](float a, float b, float d, float e) {
    return kPerStep / 12.0F * (8.0F * (d - b) - (e - a));
  };
  const auto bend = [](float a, float b, float c, float d, float e) {
    return kPerStep * kPerStep / 12.0F * (16.0F * (b + d) - (a + e) - 30.0F * c);
  };
  for (int j = 1; j + 1 < side; ++j) {
    for (int i = 1; i + 1 < side; ++i) {
      const int row = kSamplesPerCell * j;
      const int column = kSamplesPerCell * i;
      const float* r = values.ptr<float>(row) + column;
      const auto down = [&](int rows) { return values.at<float>(row + rows, column); };
      const auto corner = [&](int right, int below) {
        return values.at<float>(row + below, column + right);
      };
      auto& cell = cells[static_cast<std::size_t>(j * side + i)];
      cell[0] = r[0];
      cell[1] = slope(r[-2], r[-1], r[1], r[2]);
      cell[2] = slope(down(-2), down(-1), down(1), down(2));
      cell[3] = 0.25F * kPerStep * kPerStep *
                (corner(1, 1) - corner(-1, 1) - corner(1, -1) + corner(-1, -1));
      cell[4] = bend(r[-2], r[-1], r[0], r[1], r[2]);
      cell[5] = bend(down(-2), down(-1), r[0], down(1), down(2));
    }
  }
  mark_even(cells, side);
  return cells;
}

}  // namespace

MarkerTemplate::MarkerTemplate(const MarkerPattern& pattern, double size_px, double blur_px)
    : m_pattern(pattern), m_size_px(size_px), m_has_turn(pattern.rotational_period_rad() > 0.0) {
  m_half_width = 0.5 + (1.0 + kReachInSigmas * std::max(kWidestBlur_px, blur_px)) / size_px;
  const double wished = 2.0 * m_half_width * size_px * kSamplesPerPixel;
  m_side = std::min(static_cast<int>(std::ceil(0.5 * wished)) * 2, kMostSamples) + 1;
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

MarkerTemplate MarkerTemplate::cut_out(const MarkerPattern& pattern,
                                       const LumaFrame& frame,
                                       const Eigen::Vector2d& position_px,
                                       const Eigen::Matrix2d& px_from_pattern) {
  MarkerTemplate cut(pattern, std::sqrt(std::abs(px_from_pattern.determinant())), 0.0);
  const Eigen::Vector2d reach = cut.m_half_width * px_from_pattern.cwiseAbs().rowwise().sum();
  const detail::SplinePicture picture(frame, position_px, reach, kCutOutSmoothing_px);
  float low = std::numeric_limits<float>::max();
  float high = std::numeric_limits<float>::lowest();
  std::size_t i = 0;
  for (int row = 0; row < cut.m_side; ++row) {
    const double v = row / cut.m_samples_per_unit - cut.m_half_width;
    for (int column = 0; column < cut.m_side; ++column) {
      const double u = column / cut.m_samples_per_unit - cut.m_half_width;
      const auto grey =
          static_cast<float>(picture.at(position_px + px_from_pattern * Eigen::Vector2d(u, v)));
      cut.m_sharp[i++] = grey;
      if (std::max(std::abs(u), std::abs(v)) > 0.5) continue;
      low = std::min(low, grey);
      high = std::max(high, grey);
    }
  }
  const float scale = high > low ? 1.0F / (high - low) : 1.0F;
  for (float& value : cut.m_sharp) value = scale * (value - low);
  cut.m_cut_out = true;
  cut.blur(0.0);
  return cut;
}

MarkerTemplate MarkerTemplate::with_blur(double blur_px) const {
  if (!m_cut_out && blur_px > std::max(kWidestBlur_px, m_blur_px))
    return {m_pattern, m_size_px, blur_px};
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
  m_cells = make_cells(values);
}

detail::TemplateCells MarkerTemplate::cells() const {
  return {m_cells.front().data(),
          (m_side - 1) / kSamplesPerCell + 1,
          static_cast<float>(m_samples_per_unit / kSamplesPerCell),
          static_cast<float>(m_half_width)};
}

MarkerTemplate::Sample MarkerTemplate::at(double u, double v) const {
  const detail::TemplateSample sample =
      detail::look_up(cells(), static_cast<float>(u), static_cast<float>(v));
  return {static_cast<double>(sample.value),
          static_cast<double>(sample.du),
          static_cast<double>(sample.dv)};
}

}  // namespace twang
