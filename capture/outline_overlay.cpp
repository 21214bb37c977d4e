// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/outline_overlay.hpp"

#include "capture/detail/paint_film.hpp"
#include "capture/detail/paint_picture.hpp"

#include <opencv2/imgproc.hpp>

#include <algorithm>

namespace twang {
namespace {

const cv::Scalar kOutline(255, 170, 0);  // red, green, blue
constexpr int kFromCorner_px = 8;

using Contours = std::vector<std::vector<cv::Point>>;

/// The borders of all faces together, holes included, in `kFiner` parts of a pixel.
class Silhouette {
 public:
  static constexpr int kFiner = 2;

  Contours contours(const LumaFrame& frame, const BodyDrawing& body, std::size_t n) {
    m_mask.create(kFiner * frame.height_px, kFiner * frame.width_px, CV_8UC1);
    m_mask.setTo(0);
    const Eigen::Matrix2Xf& corners = body.corners[n];
    m_px.resize(static_cast<std::size_t>(corners.cols()));
    detail::Layer layer;
    for (Eigen::Index i = 0; i < corners.cols(); ++i) {
      const Eigen::Vector2d px =
          body.map.seen_at(body.first_frame + n, corners.col(i).cast<double>());
      m_px[static_cast<std::size_t>(i)] =
          layer.fine((px.array() + 0.5) * kFiner - Eigen::Array2d(0.5, 0.5));
    }
    for (const std::array<int, 4>& face : body.faces) {
      std::array<cv::Point, 4> quad;
      for (std::size_t k = 0; k < 4; ++k) quad[k] = m_px[static_cast<std::size_t>(face[k])];
      cv::fillConvexPoly(
          m_mask, quad.data(), 4, cv::Scalar(255), cv::LINE_8, detail::kSubpixelBits);
    }
    Contours contours;
    cv::findContours(m_mask, contours, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
    return contours;
  }

 private:
  cv::Mat m_mask;
  std::vector<cv::Point> m_px;
};

void draw_contours(detail::Picture& picture, const Contours& contours) {
  const auto place = [](const cv::Point& point) {
    return Eigen::Vector2d((point.x + 0.5) / Silhouette::kFiner - 0.5,
                           (point.y + 0.5) / Silhouette::kFiner - 0.5);
  };
  for (const std::vector<cv::Point>& contour : contours)
    for (std::size_t i = 0; i < contour.size(); ++i)
      detail::draw_line(
          picture, place(contour[i]), place(contour[(i + 1) % contour.size()]), kOutline);
}

}  // namespace

void write_outline_overlay(const std::filesystem::path& video,
                           const std::filesystem::path& overlay,
                           const BodyDrawing& body,
                           double fps,
                           const ProgressCallback& progress) {
  Silhouette silhouette;
  const auto paint = [&](detail::Picture& picture, const LumaFrame& frame, std::size_t n) {
    draw_contours(picture, silhouette.contours(frame, body, n - body.first_frame));
    detail::write_word(picture, body.name, {kFromCorner_px, kFromCorner_px}, 0.0, kOutline);
  };
  detail::paint_film(video,
                     overlay,
                     {body.first_frame, body.corners.size(), fps, "drawing the outline"},
                     paint,
                     progress);
}

}  // namespace twang
