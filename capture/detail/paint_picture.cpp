// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/paint_picture.hpp"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace twang::detail {
namespace {

constexpr int kTextHeight_px = 360;  // picture height at which the text has its natural size
constexpr std::uint8_t kNoChroma = 128;

cv::Scalar same(const cv::Scalar& rgb) { return rgb; }
// Full-range BT.601, as the film's writer has it.
cv::Scalar luma(const cv::Scalar& rgb) {
  return cv::Scalar(0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2]);
}
cv::Scalar blue(const cv::Scalar& rgb) {
  return cv::Scalar(kNoChroma + (rgb[2] - luma(rgb)[0]) / 1.772);
}
cv::Scalar red(const cv::Scalar& rgb) {
  return cv::Scalar(kNoChroma + (rgb[0] - luma(rgb)[0]) / 1.402);
}

}  // namespace

cv::Point Layer::fine(const Eigen::Vector2d& px) const {
  const double steps = 1 << kSubpixelBits;
  const Eigen::Vector2d at = (px.array() + 0.5) / shrink - 0.5;
  return {static_cast<int>(std::lround(at.x() * steps)),
          static_cast<int>(std::lround(at.y() * steps))};
}

int Layer::thickness(int px) const { return std::max(1, px / shrink); }

Picture picture_of(cv::Mat& colour) { return {{colour, 1, same}}; }

Picture picture_of(const PicturePlanes& planes) {
  const auto plane = [](std::uint8_t* pixels, std::ptrdiff_t stride, int width, int height) {
    return cv::Mat(height, width, CV_8UC1, pixels, static_cast<std::size_t>(stride));
  };
  const int width = planes.width_px;
  const int height = planes.height_px;
  return {{plane(planes.luma, planes.luma_stride, width, height), 1, luma},
          {plane(planes.blue, planes.chroma_stride, width / 2, height / 2), 2, blue},
          {plane(planes.red, planes.chroma_stride, width / 2, height / 2), 2, red}};
}

void draw_line(Picture& picture,
               const Eigen::Vector2d& from,
               const Eigen::Vector2d& to,
               const cv::Scalar& colour) {
  for (Layer& layer : picture) {
    cv::line(layer.pixels,
             layer.fine(from),
             layer.fine(to),
             layer.ink(colour),
             1,
             cv::LINE_AA,
             kSubpixelBits);
  }
}

void draw_circle(Picture& picture,
                 const Eigen::Vector2d& at,
                 double radius_px,
                 const cv::Scalar& colour) {
  for (Layer& layer : picture) {
    cv::circle(layer.pixels,
               layer.fine(at),
               static_cast<int>(radius_px / layer.shrink * (1 << kSubpixelBits)),
               layer.ink(colour),
               layer.thickness(2),
               cv::LINE_AA,
               kSubpixelBits);
  }
}

void write_word(Picture& picture,
                const std::string& word,
                const Eigen::Vector2d& at,
                double beside_px,
                const cv::Scalar& colour) {
  const cv::Mat& whole = picture.front().pixels;
  const double scale = std::max(0.4, 0.4 * whole.rows / kTextHeight_px);
  const int thick = std::max(1, static_cast<int>(std::lround(scale)));
  int below = 0;
  const cv::Size size = cv::getTextSize(word, cv::FONT_HERSHEY_SIMPLEX, scale, thick, &below);
  cv::Point origin(static_cast<int>(at.x() + beside_px), static_cast<int>(at.y() - beside_px));
  if (origin.x + size.width > whole.cols) {
    origin.x = static_cast<int>(at.x() - beside_px) - size.width;
  }
  origin.x = std::clamp(origin.x, 0, std::max(0, whole.cols - size.width));
  origin.y = std::clamp(origin.y, size.height, std::max(size.height, whole.rows - below));
  for (const auto& [ink, width] : {std::pair{cv::Scalar(0, 0, 0), thick + 2}, {colour, thick}}) {
    for (Layer& layer : picture) {
      cv::putText(layer.pixels,
                  word,
                  origin / layer.shrink,
                  cv::FONT_HERSHEY_SIMPLEX,
                  scale / layer.shrink,
                  layer.ink(ink),
                  layer.thickness(width),
                  cv::LINE_AA);
    }
  }
}

void copy_grey(const LumaFrame& frame, const PicturePlanes& planes) {
  for (int y = 0; y < planes.height_px; ++y) {
    const std::uint8_t* row = frame.pixels + std::min(y, frame.height_px - 1) * frame.stride;
    std::uint8_t* target = planes.luma + y * planes.luma_stride;
    std::memcpy(target, row, static_cast<std::size_t>(frame.width_px));
    std::memset(target + frame.width_px,
                row[frame.width_px - 1],
                static_cast<std::size_t>(planes.width_px - frame.width_px));
  }
  const auto half = static_cast<std::size_t>(planes.width_px / 2);
  for (int y = 0; y < planes.height_px / 2; ++y) {
    std::memset(planes.blue + y * planes.chroma_stride, kNoChroma, half);
    std::memset(planes.red + y * planes.chroma_stride, kNoChroma, half);
  }
}

}  // namespace twang::detail
