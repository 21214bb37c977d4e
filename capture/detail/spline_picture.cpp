// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/spline_picture.hpp"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace twang::detail {
namespace {

// What the filters need beyond the part that is asked for.
constexpr int kMargin_px = 12;
constexpr int kPrefilterReach = 10;  // 0.27 to that power is rounding in a float

/// The filter that makes spline coefficients of samples: sqrt(3) z^|k|, z = sqrt(3) − 2.
cv::Mat prefilter() {
  cv::Mat kernel(1, 2 * kPrefilterReach + 1, CV_32F);
  const double pole = std::sqrt(3.0) - 2.0;
  for (int k = -kPrefilterReach; k <= kPrefilterReach; ++k) {
    kernel.at<float>(0, k + kPrefilterReach) =
        static_cast<float>(std::sqrt(3.0) * std::pow(pole, std::abs(k)));
  }
  return kernel;
}

/// Cubic B-splines at distances t + 1, t, 1 − t, 2 − t.
std::array<double, 4> weights(double t) {
  const double s = 1.0 - t;
  return {s * s * s / 6.0,
          (4.0 - 3.0 * t * t * (2.0 - t)) / 6.0,
          (4.0 - 3.0 * s * s * (2.0 - s)) / 6.0,
          t * t * t / 6.0};
}

}  // namespace

SplinePicture::SplinePicture(const LumaFrame& frame,
                             const Eigen::Vector2d& middle_px,
                             const Eigen::Vector2d& reach_px,
                             double smoothing_px) {
  const Eigen::Vector2d low = middle_px - reach_px;
  const Eigen::Vector2d high = middle_px + reach_px;
  const auto bound = [](double value, int most) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(most)));
  };
  m_x0 = bound(std::floor(low.x()) - kMargin_px, frame.width_px - 1);
  m_y0 = bound(std::floor(low.y()) - kMargin_px, frame.height_px - 1);
  m_width = bound(std::ceil(high.x()) + kMargin_px + 1, frame.width_px) - m_x0;
  m_height = bound(std::ceil(high.y()) + kMargin_px + 1, frame.height_px) - m_y0;
  m_width = std::max(m_width, 1);
  m_height = std::max(m_height, 1);
  // OpenCV's header takes what it only reads as writable.
  auto* first = const_cast<std::uint8_t*>(frame.pixels + m_y0 * frame.stride + m_x0);
  const cv::Mat grey(m_height, m_width, CV_8UC1, first, static_cast<std::size_t>(frame.stride));
  cv::Mat smooth;
  grey.convertTo(smooth, CV_32F);
  if (smoothing_px > 0.0) {
    cv::GaussianBlur(smooth, smooth, {0, 0}, smoothing_px, smoothing_px, cv::BORDER_REFLECT_101);
  }
  m_coefficients.resize(static_cast<std::size_t>(m_width) * static_cast<std::size_t>(m_height));
  cv::Mat coefficients(m_height, m_width, CV_32F, m_coefficients.data());
  cv::sepFilter2D(smooth,
                  coefficients,
                  CV_32F,
                  prefilter(),
                  prefilter(),
                  cv::Point(-1, -1),
                  0.0,
                  cv::BORDER_REFLECT_101);
}

double SplinePicture::at(const Eigen::Vector2d& px) const {
  const double x = std::clamp(px.x() - m_x0, 0.0, m_width - 1.0);
  const double y = std::clamp(px.y() - m_y0, 0.0, m_height - 1.0);
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const std::array<double, 4> across = weights(x - column);
  const std::array<double, 4> down = weights(y - row);
  double sum = 0.0;
  for (int j = 0; j < 4; ++j) {
    const int from = std::clamp(row + j - 1, 0, m_height - 1);
    const float* line = m_coefficients.data() + static_cast<std::ptrdiff_t>(from) * m_width;
    double of_row = 0.0;
    for (int i = 0; i < 4; ++i) {
      of_row += across[static_cast<std::size_t>(i)] *
                static_cast<double>(line[std::clamp(column + i - 1, 0, m_width - 1)]);
    }
    sum += down[static_cast<std::size_t>(j)] * of_row;
  }
  return sum;
}

}  // namespace twang::detail
