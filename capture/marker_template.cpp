// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/marker_template.hpp"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace twang {
namespace {

// Of the sharp marker's samples every other one is a cell. The expansion about the nearest then
// errs by under 0.1 % of the contrast.
constexpr int kSamplesPerCell = 2;
// Cells over which a template is noted not to change, at most.
constexpr float kMostEven = 500.0F;
// Beyond the marker, what is left of the blur is less than a rounding error [standard deviations].
constexpr double kNothingLeft = 5.0;

/// The samples but for so many along each edge, blurred.
cv::Mat blurred(const SharpMarker& sharp, double blur_px, int edge) {
  // OpenCV's header takes what it only reads as writable.
  auto* first = const_cast<float*>(sharp.samples().data());
  const cv::Mat whole(sharp.side(), sharp.side(), CV_32F, first);
  const int side = sharp.side() - 2 * edge;
  if (!(blur_px > 0.0)) return whole(cv::Rect(edge, edge, side, side));
  const double sigma = blur_px / sharp.size_px() * sharp.samples_per_unit();
  const int half = sharp.is_mirrored() ? side / 2 : 0;
  cv::Mat values;
  cv::GaussianBlur(whole(cv::Rect(edge, edge, side - half, side - half)),
                   values,
                   {0, 0},
                   sigma,
                   sigma,
                   cv::BORDER_REPLICATE);
  if (half > 0) cv::copyMakeBorder(values, values, 0, half, 0, half, cv::BORDER_REFLECT_101);
  return values;
}

}  // namespace

MarkerTemplate::MarkerTemplate(const MarkerPattern& pattern, double size_px, double blur_px)
    : MarkerTemplate(SharpMarker(pattern, size_px, blur_px), blur_px) {}

MarkerTemplate::MarkerTemplate(const SharpMarker& sharp, double blur_px)
    : m_pattern(sharp.pattern()),
      m_size_px(sharp.size_px()),
      m_blur_px(blur_px),
      m_has_turn(sharp.pattern().rotational_period_rad() > 0.0),
      m_cut_out(sharp.is_cut_out()),
      m_cells_per_unit(sharp.samples_per_unit() / kSamplesPerCell) {
  // Of what is printed, as far as the blur reaches.
  const double reach = 0.5 + (1.0 + kNothingLeft * blur_px) / m_size_px;
  const int spare = static_cast<int>((sharp.half_width() - reach) * m_cells_per_unit) - 1;
  const int first = m_cut_out ? 0 : kSamplesPerCell * std::max(0, spare);
  const cv::Mat values = blurred(sharp, blur_px, first);
  m_side = (values.rows - 1) / kSamplesPerCell + 1;
  make_cells(values.ptr<float>(),
             static_cast<std::ptrdiff_t>(values.step1()),
             sharp.is_mirrored() && !m_cut_out);
}

MarkerTemplate MarkerTemplate::cut_out(const MarkerPattern& pattern,
                                       const LumaFrame& frame,
                                       const Eigen::Vector2d& position_px,
                                       const Eigen::Matrix2d& px_from_pattern) {
  return {SharpMarker::cut_out(pattern, frame, position_px, px_from_pattern), 0.0};
}

MarkerTemplate::Cell& MarkerTemplate::cell(int column, int row) {
  constexpr int kWithin = detail::kCellPhases - 1;
  const int square = ((row & kWithin) << detail::kCellPhaseBits) + (column & kWithin);
  const int line = square * m_part + (row >> detail::kCellPhaseBits);
  const int at = line * m_part + (column >> detail::kCellPhaseBits);
  return m_table->cells[static_cast<std::size_t>(at)];
}

namespace {

/// Value and derivatives as a cell holds them.
using Expansion = std::array<float, 6>;

/// By the cell's index (differences of fourth order), at a sample.
/// @param stride  from one row of samples to the next
Expansion cell_at(const float* r, std::ptrdiff_t stride) {
  constexpr float kPerStep = static_cast<float>(kSamplesPerCell);
  const auto slope = [](float a, float b, float d, float e) {
    return kPerStep / 12.0F * (8.0F * (d - b) - (e - a));
  };
  const auto bend = [](float a, float b, float c, float d, float e) {
    return kPerStep * kPerStep / 12.0F * (16.0F * (b + d) - (a + e) - 30.0F * c);
  };
  const auto down = [&](int rows) { return r[rows * stride]; };
  const auto corner = [&](int right, int below) { return r[below * stride + right]; };
  return {
      r[0],
      slope(r[-2], r[-1], r[1], r[2]),
      slope(down(-2), down(-1), down(1), down(2)),
      0.25F * kPerStep * kPerStep * (corner(1, 1) - corner(-1, 1) - corner(1, -1) + corner(-1, -1)),
      bend(r[-2], r[-1], r[0], r[1], r[2]),
      bend(down(-2), down(-1), r[0], down(1), down(2))};
}

std::array<detail::CellNumber, detail::kCellNumbers> rounded(const Expansion& f) {
  constexpr float kMost = 32767.0F;
  std::array<detail::CellNumber, detail::kCellNumbers> cell{};
  for (std::size_t k = 0; k < f.size(); ++k) {
    const float scaled = std::clamp(detail::kCellScale * f[k], -kMost, kMost);
    cell[k] = static_cast<detail::CellNumber>(std::lrint(scaled));
  }
  return cell;
}

}  // namespace

/// A cell for every other sample; beyond the square all is paper.
/// @param first     of the samples
/// @param stride    from one row of them to the next
/// @param mirrored  the pattern is its own mirror image, both ways: a quarter says all
void MarkerTemplate::make_cells(const float* first, std::ptrdiff_t stride, bool mirrored) {
  m_part = (m_side + detail::kCellPhases - 1) / detail::kCellPhases;
  const auto padded = static_cast<std::size_t>(detail::kCellPhases * m_part);
  m_table = std::make_shared<Table>();
  m_table->cells.assign(padded * padded, rounded({1.0F}));
  const int end = mirrored ? (m_side + 1) / 2 : m_side - 1;
  for (int j = 1; j < end; ++j) {
    for (int i = 1; i < end; ++i) {
      const Cell f = rounded(cell_at(first + kSamplesPerCell * (j * stride + i), stride));
      cell(i, j) = f;
      if (!mirrored) continue;
      const int beside = m_side - 1 - i;
      const int below = m_side - 1 - j;
      const auto mirrored_by = [&f](int along_i, int along_j) {
        const auto signed_by = [](int sign, detail::CellNumber number) {
          return static_cast<detail::CellNumber>(sign * number);
        };
        return Cell{f[0],
                    signed_by(along_i, f[1]),
                    signed_by(along_j, f[2]),
                    signed_by(along_i * along_j, f[3]),
                    f[4],
                    f[5]};
      };
      cell(beside, j) = mirrored_by(-1, 1);
      cell(i, below) = mirrored_by(1, -1);
      cell(beside, below) = mirrored_by(-1, -1);
    }
  }
}

/// Writes into each cell how far from it no cell has a slope worth the name.
void MarkerTemplate::mark_even() {
  if (std::exchange(m_table->even_marked, true)) return;
  cv::Mat even(m_side, m_side, CV_8UC1);
  for (int j = 0; j < m_side; ++j) {
    for (int i = 0; i < m_side; ++i) {
      const Cell& f = cell(i, j);
      even.at<std::uint8_t>(j, i) = f[1] == 0 && f[2] == 0 ? 255 : 0;
    }
  }
  cv::Mat distance;
  cv::distanceTransform(even, distance, cv::DIST_L2, cv::DIST_MASK_3);
  for (int j = 0; j < m_side; ++j) {
    for (int i = 0; i < m_side; ++i) {
      // The transform errs by a twentieth.
      const float safely = std::clamp(0.95F * distance.at<float>(j, i) - 1.0F, 0.0F, kMostEven);
      cell(i, j)[6] = static_cast<detail::CellNumber>(detail::kEvenScale * safely);
    }
  }
}

detail::TemplateCells MarkerTemplate::cells() const {
  return {m_table->cells.front().data(),
          m_side,
          m_part,
          static_cast<float>(m_cells_per_unit),
          static_cast<float>(0.5 * (m_side - 1) / m_cells_per_unit)};
}

MarkerTemplate::Sample MarkerTemplate::at(double u, double v) const {
  const detail::TemplateSample sample =
      detail::look_up(cells(), static_cast<float>(u), static_cast<float>(v));
  return {static_cast<double>(sample.value),
          static_cast<double>(sample.du),
          static_cast<double>(sample.dv)};
}

}  // namespace twang
