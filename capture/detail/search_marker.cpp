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
constexpr double kPeaksApart = 0.5;  // peaks, in sizes
// A picture is made smaller before it is searched as long as the marker keeps this size in it.
constexpr double kSmallest_px = 10.0;
constexpr int kMostShrink = 4;
// An area from so many markers' sizes on is searched that way: in a smaller one it saves nothing.
constexpr double kLargeArea = 5.0;
// In the smaller picture a marker correlates less, since no pixel need lie on its centre: by up to
// 0.18 where it is the smallest.
constexpr double kShrinkLoss = 0.25;
constexpr std::size_t kMostCoarsePeaks = 32;

/// A rectangle of a frame's pixels, half open.
struct Area {
  int x0, y0, x1, y1;
  [[nodiscard]] int width() const { return x1 - x0; }
  [[nodiscard]] int height() const { return y1 - y0; }
};

/// What lies within `half` of the places from `low` to `high`, as far as the frame goes.
Area area_around(const LumaFrame& frame,
                 const Eigen::Vector2d& low,
                 const Eigen::Vector2d& high,
                 int half) {
  const auto bound = [](double value, int most) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(most)));
  };
  return {bound(std::floor(low.x()) - half, frame.width_px),
          bound(std::floor(low.y()) - half, frame.height_px),
          bound(std::ceil(high.x()) + half + 1, frame.width_px),
          bound(std::ceil(high.y()) + half + 1, frame.height_px)};
}

cv::Mat pixels_of(const LumaFrame& frame, const Area& area) {
  // OpenCV's header takes what it only reads as writable.
  auto* first = const_cast<std::uint8_t*>(frame.pixels + area.y0 * frame.stride + area.x0);
  return {area.height(), area.width(), CV_8UC1, first, static_cast<std::size_t>(frame.stride)};
}

/// The marker as it lies in a picture shrunk by an integer.
cv::Mat draw_marker(const MarkerTemplate& marker,
                    const Eigen::Matrix2d& px_from_pattern,
                    int shrink) {
  const double half_px = kHalfSide * px_from_pattern.cwiseAbs().rowwise().sum().maxCoeff();
  const int half = std::max(2, static_cast<int>(std::lround(half_px / shrink)));
  const Eigen::Matrix2d pattern_from_px = px_from_pattern.inverse();
  const int side = shrink * (2 * half + 1);
  cv::Mat drawn(side, side, CV_8UC1);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const Eigen::Vector2d uv =
          pattern_from_px * (Eigen::Vector2d(x, y).array() - 0.5 * (side - 1)).matrix();
      drawn.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(std::lround(20.0 + 200.0 * marker.at(uv.x(), uv.y()).value));
    }
  }
  if (shrink > 1) cv::resize(drawn, drawn, {side / shrink, side / shrink}, 0, 0, cv::INTER_AREA);
  return drawn;
}

/// Local maxima of the correlation, best first.
std::vector<MarkerPeak> peaks_of(cv::Mat& match, double least, double apart, std::size_t most) {
  std::vector<MarkerPeak> peaks;
  while (peaks.size() < most) {
    double best = 0.0;
    cv::Point at;
    cv::minMaxLoc(match, nullptr, &best, nullptr, &at);
    if (!(best >= least)) break;
    peaks.push_back({Eigen::Vector2d(at.x, at.y), best});
    cv::circle(match, at, static_cast<int>(std::ceil(apart)), cv::Scalar(-1.0), cv::FILLED);
  }
  return peaks;
}

/// One marker, sought by correlation with its picture.
class MarkerSearch {
 public:
  MarkerSearch(const LumaFrame& frame,
               const MarkerTemplate& marker,
               const Eigen::Matrix2d& px_from_pattern)
      : m_frame(frame),
        m_marker(marker),
        m_px_from_pattern(px_from_pattern),
        m_drawn(draw_marker(marker, px_from_pattern, 1)),
        m_size_px(std::sqrt(std::abs(px_from_pattern.determinant()))) {}

  [[nodiscard]] std::vector<MarkerPeak> everywhere(const Eigen::Vector2d& middle_px,
                                                   double reach_px,
                                                   double least,
                                                   std::size_t most) const;
  [[nodiscard]] std::vector<MarkerPeak> coarse_to_fine(const Eigen::Vector2d& middle_px,
                                                       double reach_px,
                                                       double least) const;

  [[nodiscard]] int shrink(double reach_px) const;

 private:
  const LumaFrame& m_frame;
  const MarkerTemplate& m_marker;
  const Eigen::Matrix2d& m_px_from_pattern;
  cv::Mat m_drawn;
  double m_size_px;
};

/// How much smaller the picture may be made for a search of that reach.
int MarkerSearch::shrink(double reach_px) const {
  const MarkerKind kind = m_marker.pattern().kind();
  const bool fine =
      kind == MarkerKind::ArUco || kind == MarkerKind::AprilTag || kind == MarkerKind::Patch;
  if (fine || 2.0 * reach_px < kLargeArea * m_size_px) return 1;
  return std::clamp(static_cast<int>(m_size_px / kSmallest_px), 1, kMostShrink);
}

std::vector<MarkerPeak> MarkerSearch::everywhere(const Eigen::Vector2d& middle_px,
                                                 double reach_px,
                                                 double least,
                                                 std::size_t most) const {
  const int half = m_drawn.rows / 2;
  const Area area =
      area_around(m_frame, middle_px.array() - reach_px, middle_px.array() + reach_px, half);
  if (area.width() < m_drawn.cols || area.height() < m_drawn.rows) return {};
  cv::Mat match;
  cv::matchTemplate(pixels_of(m_frame, area), m_drawn, match, cv::TM_CCOEFF_NORMED);
  std::vector<MarkerPeak> peaks =
      peaks_of(match, least, std::max(1.0, kPeaksApart * m_size_px), most);
  for (MarkerPeak& peak : peaks) {
    peak.position_px += Eigen::Vector2d(area.x0 + half, area.y0 + half);
  }
  return peaks;
}

/// In a smaller picture first; what it shows is then looked at in the picture itself.
std::vector<MarkerPeak> MarkerSearch::coarse_to_fine(const Eigen::Vector2d& middle_px,
                                                     double reach_px,
                                                     double least) const {
  const int by = shrink(reach_px);
  const cv::Mat drawn = draw_marker(m_marker, m_px_from_pattern, by);
  const int half = drawn.rows / 2;
  Area area = area_around(
      m_frame, middle_px.array() - reach_px, middle_px.array() + reach_px, by * (half + 1));
  area.x1 -= area.width() % by;
  area.y1 -= area.height() % by;
  if (area.width() < by * drawn.cols || area.height() < by * drawn.rows) {
    return everywhere(middle_px, reach_px, least, kMostPeaks);
  }
  cv::Mat small, match;
  cv::resize(pixels_of(m_frame, area),
             small,
             {area.width() / by, area.height() / by},
             0,
             0,
             cv::INTER_AREA);
  cv::matchTemplate(small, drawn, match, cv::TM_CCOEFF_NORMED);
  const double apart = std::max(1.0, kPeaksApart * m_size_px / by);
  std::vector<MarkerPeak> peaks;
  for (const MarkerPeak& coarse : peaks_of(match, least - kShrinkLoss, apart, kMostCoarsePeaks)) {
    const Eigen::Vector2d at = Eigen::Vector2d(area.x0, area.y0).array() +
                               by * (coarse.position_px.array() + half) + 0.5 * (by - 1);
    const auto best = everywhere(at, by, least, 1);
    if (!best.empty()) peaks.push_back(best.front());
  }
  std::sort(peaks.begin(), peaks.end(), [](const MarkerPeak& a, const MarkerPeak& b) {
    return a.correlation > b.correlation;
  });
  if (peaks.size() > kMostPeaks) peaks.resize(kMostPeaks);
  return peaks;
}

}  // namespace

std::vector<MarkerPeak> search_marker(const LumaFrame& frame,
                                      const MarkerTemplate& marker,
                                      const Eigen::Matrix2d& px_from_pattern,
                                      const Eigen::Vector2d& middle_px,
                                      double reach_px,
                                      double least) {
  const MarkerSearch search(frame, marker, px_from_pattern);
  if (search.shrink(reach_px) > 1) return search.coarse_to_fine(middle_px, reach_px, least);
  return search.everywhere(middle_px, reach_px, least, kMostPeaks);
}

}  // namespace twang::detail
