// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/search_marker.hpp"

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace twang::detail {
namespace {

// Half the side of the picture that is correlated, in sizes: the marker and a rim of paper.
constexpr double kHalfSide = 0.6;
constexpr std::size_t kMostPeaks = 16;
constexpr double kApart = 0.5;  // peaks, in sizes

cv::Mat draw_marker(const MarkerTemplate& marker, const Eigen::Matrix2d& px_from_pattern) {
  const double half_px = kHalfSide * px_from_pattern.cwiseAbs().rowwise().sum().maxCoeff();
  const int half = std::max(2, static_cast<int>(std::lround(half_px)));
  const Eigen::Matrix2d pattern_from_px = px_from_pattern.inverse();
  cv::Mat drawn(2 * half + 1, 2 * half + 1, CV_8UC1);
  for (int y = -half; y <= half; ++y) {
    for (int x = -half; x <= half; ++x) {
      const Eigen::Vector2d uv = pattern_from_px * Eigen::Vector2d(x, y);
      drawn.at<std::uint8_t>(y + half, x + half) =
          static_cast<std::uint8_t>(std::lround(20.0 + 200.0 * marker.at(uv.x(), uv.y()).value));
    }
  }
  return drawn;
}

}  // namespace

std::vector<MarkerPeak> search_marker(const LumaFrame& frame,
                                      const MarkerTemplate& marker,
                                      const Eigen::Matrix2d& px_from_pattern,
                                      const Eigen::Vector2d& middle_px,
                                      double reach_px,
                                      double least) {
  const cv::Mat drawn = draw_marker(marker, px_from_pattern);
  const int half = drawn.rows / 2;
  const auto bound = [](double value, int most) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(most)));
  };
  const int x0 = bound(std::floor(middle_px.x() - reach_px) - half, frame.width_px);
  const int y0 = bound(std::floor(middle_px.y() - reach_px) - half, frame.height_px);
  const int x1 = bound(std::ceil(middle_px.x() + reach_px) + half + 1, frame.width_px);
  const int y1 = bound(std::ceil(middle_px.y() + reach_px) + half + 1, frame.height_px);
  if (x1 - x0 < drawn.cols || y1 - y0 < drawn.rows) return {};
  // OpenCV's header takes what it only reads as writable.
  auto* first = const_cast<std::uint8_t*>(frame.pixels + y0 * frame.stride + x0);
  const cv::Mat area(y1 - y0, x1 - x0, CV_8UC1, first, static_cast<std::size_t>(frame.stride));
  cv::Mat match;
  cv::matchTemplate(area, drawn, match, cv::TM_CCOEFF_NORMED);

  const double apart = std::max(1.0, kApart * std::sqrt(std::abs(px_from_pattern.determinant())));
  std::vector<MarkerPeak> peaks;
  while (peaks.size() < kMostPeaks) {
    double best = 0.0;
    cv::Point at;
    cv::minMaxLoc(match, nullptr, &best, nullptr, &at);
    if (!(best >= least)) break;
    peaks.push_back({Eigen::Vector2d(at.x + x0 + half, at.y + y0 + half), best});
    cv::circle(match, at, static_cast<int>(std::ceil(apart)), cv::Scalar(-1.0), cv::FILLED);
  }
  return peaks;
}

}  // namespace twang::detail
