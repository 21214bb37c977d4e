// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/outline_overlay.hpp"

#include "capture/detail/paint_picture.hpp"
#include "core/error.hpp"

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include <algorithm>

namespace twang {
namespace {

const cv::Scalar kOutline(255, 170, 0);  // red, green, blue
constexpr int kOutlineCrf = 23;          // good enough to look at
constexpr int kFromCorner_px = 8;

using Contours = std::vector<std::vector<cv::Point>>;

/// The borders of all faces together, holes included, in `kFiner` parts of a pixel.
class Silhouette {
 public:
  static constexpr int kFiner = 2;

  Silhouette(int width_px, int height_px)
      : m_mask(kFiner * height_px, kFiner * width_px, CV_8UC1) {}

  Contours contours(const BodyDrawing& body, std::size_t n) {
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
  VideoReader reader(video);
  const VideoInfo& info = reader.info();
  VideoWriter writer(
      overlay, info.width_px, info.height_px, {.fps = fps, .crf = kOutlineCrf, .quick = true});
  Silhouette silhouette(info.width_px, info.height_px);
  const std::size_t end = body.first_frame + body.corners.size();
  for (std::size_t n = 0; n < end; ++n) {
    const auto frame = reader.read();
    if (!frame) {
      throw InputError(fmt::format(
          "{}: has {} frames, must have the {} that are drawn", video.string(), n, end));
    }
    if (n < body.first_frame) continue;
    writer.write([&](const PicturePlanes& planes) {
      detail::copy_grey(*frame, planes);
      detail::Picture picture = detail::picture_of(planes);
      draw_contours(picture, silhouette.contours(body, n - body.first_frame));
      detail::write_word(picture, body.name, {kFromCorner_px, kFromCorner_px}, 0.0, kOutline);
    });
    report_progress(progress,
                    {"drawing the outline",
                     static_cast<double>(n - body.first_frame + 1),
                     static_cast<double>(body.corners.size()),
                     "frames"});
  }
  writer.finish();
}

}  // namespace twang
