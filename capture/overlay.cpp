// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/overlay.hpp"

#include "capture/video_reader.hpp"
#include "capture/video_writer.hpp"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <string>
#include <utility>

namespace twang {
namespace {

// Red, green, blue; told apart by most eyes and on grey.
const std::array kColours = {cv::Scalar(255, 170, 0),
                             cv::Scalar(0, 190, 255),
                             cv::Scalar(120, 230, 60),
                             cv::Scalar(255, 110, 200),
                             cv::Scalar(240, 230, 40),
                             cv::Scalar(150, 140, 255)};
const cv::Scalar kAlarm(255, 40, 40);
constexpr std::size_t kTail = 24;    // frames of path behind a marker
constexpr int kShift = 4;            // OpenCV draws to a sixteenth of a pixel
constexpr int kTextHeight_px = 360;  // picture height at which the text has its natural size
constexpr double kArm = 0.75;        // of a crosshair, over the marker's size [-]
constexpr double kBeside = 0.6;      // from a marker to its name, over its size [-]
constexpr double kRing = 0.85;       // radius of the ring around a marker, over its size [-]
constexpr int kCrf = 23;             // good enough to look at
constexpr int kBorder_px = 6;        // around a repeated frame
constexpr std::uint8_t kNoChroma = 128;

/// One array that is painted: all three colours, or one plane of a picture that keeps luma apart.
struct Layer {
  cv::Mat pixels;
  int shrink = 1;  // pixels of the picture to one of this array
  cv::Scalar (*ink)(const cv::Scalar& rgb) = nullptr;

  [[nodiscard]] cv::Point fine(const Eigen::Vector2d& px) const {
    const double steps = 1 << kShift;
    const Eigen::Vector2d at = (px.array() + 0.5) / shrink - 0.5;
    return {static_cast<int>(std::lround(at.x() * steps)),
            static_cast<int>(std::lround(at.y() * steps))};
  }
  [[nodiscard]] int thickness(int px) const { return std::max(1, px / shrink); }
};
using Picture = std::vector<Layer>;

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

const cv::Scalar& colour_of(std::size_t marker) { return kColours[marker % kColours.size()]; }

void draw_line(Picture& picture,
               const Eigen::Vector2d& from,
               const Eigen::Vector2d& to,
               const cv::Scalar& colour) {
  for (Layer& layer : picture) {
    cv::line(
        layer.pixels, layer.fine(from), layer.fine(to), layer.ink(colour), 1, cv::LINE_AA, kShift);
  }
}

void draw_circle(Picture& picture,
                 const Eigen::Vector2d& at,
                 double radius_px,
                 const cv::Scalar& colour) {
  for (Layer& layer : picture) {
    cv::circle(layer.pixels,
               layer.fine(at),
               static_cast<int>(radius_px / layer.shrink * (1 << kShift)),
               layer.ink(colour),
               layer.thickness(2),
               cv::LINE_AA,
               kShift);
  }
}

void draw_path(Picture& picture,
               const std::vector<Eigen::Vector2d>& path,
               std::size_t first,
               std::size_t last,
               const cv::Scalar& colour) {
  for (std::size_t n = first + 1; n <= last && n < path.size(); ++n) {
    if (!path[n].allFinite() || !path[n - 1].allFinite()) continue;
    draw_line(picture, path[n - 1], path[n], colour);
  }
}

/// A word beside a place, dark under light so that it reads on any ground, kept in the picture.
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

void draw_cross(Picture& picture,
                const Eigen::Vector2d& at,
                const Eigen::Vector2d& arm_px,
                const cv::Scalar& colour) {
  const Eigen::Vector2d other(-arm_px.y(), arm_px.x());
  draw_line(picture, at - arm_px, at + arm_px, colour);
  draw_line(picture, at - other, at + other, colour);
}

/// The last place where a marker was seen up to a frame, or else the first.
const Eigen::Vector2d* last_seen(const MarkerTrack& track, std::size_t frame) {
  const auto begin = track.position_px.begin();
  const auto now = begin + static_cast<std::ptrdiff_t>(std::min(frame, track.position_px.size()));
  const auto seen = [](const Eigen::Vector2d& px) { return px.allFinite(); };
  const auto back = std::find_if(std::make_reverse_iterator(now), track.position_px.rend(), seen);
  if (back != track.position_px.rend()) return &*back;
  const auto ahead = std::find_if(now, track.position_px.end(), seen);
  return ahead == track.position_px.end() ? nullptr : &*ahead;
}

void draw_frame(Picture& picture, const TrackDrawing& drawing, std::size_t n) {
  for (std::size_t i = 0; i < drawing.tracks.size(); ++i) {
    const MarkerTrack& track = drawing.tracks[i];
    const double size_px = drawing.size_px[i];
    draw_path(picture, track.position_px, n > kTail ? n - kTail : 0, n, colour_of(i));
    if (n < track.position_px.size() && track.position_px[n].allFinite()) {
      draw_cross(picture, track.position_px[n], {kArm * size_px, 0.0}, colour_of(i));
      write_word(picture, track.id, track.position_px[n], kBeside * size_px, colour_of(i));
    } else if (const Eigen::Vector2d* last = last_seen(track, n)) {
      draw_circle(picture, *last, kArm * size_px, kAlarm);
      draw_cross(
          picture, *last, Eigen::Vector2d::Constant(kArm * size_px / std::sqrt(2.0)), kAlarm);
      write_word(picture, track.id + " lost", *last, kBeside * size_px, kAlarm);
    }
  }
  if (n < drawing.doubled.size() && drawing.doubled[n]) {
    for (Layer& layer : picture) {
      cv::rectangle(layer.pixels,
                    cv::Rect({0, 0}, layer.pixels.size()),
                    layer.ink(kAlarm),
                    layer.thickness(kBorder_px));
    }
    write_word(picture, "repeated frame", {2.0 * kBorder_px, 2.0 * kBorder_px}, 0.0, kAlarm);
  }
}

/// The picture in grey; where it is a row or column larger than the film's, the last one twice.
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

}  // namespace

Image draw_tracks(const Image& grey, const TrackDrawing& drawing, std::size_t frame) {
  // OpenCV's header takes what it only reads as writable.
  const cv::Mat luminance(
      grey.height_px, grey.width_px, CV_8UC1, const_cast<std::uint8_t*>(grey.pixels.data()));
  Image image{grey.width_px, grey.height_px, 3, {}};
  image.pixels.resize(3 * grey.pixels.size());
  cv::Mat colour(image.height_px, image.width_px, CV_8UC3, image.pixels.data());
  cv::cvtColor(luminance, colour, cv::COLOR_GRAY2RGB);
  Picture picture = picture_of(colour);
  for (std::size_t i = 0; i < drawing.tracks.size(); ++i) {
    const MarkerTrack& track = drawing.tracks[i];
    draw_path(picture, track.position_px, 0, track.position_px.size(), colour_of(i));
    const Eigen::Vector2d& at = track.position_px[frame];
    if (!at.allFinite()) continue;
    const double radius_px = kRing * drawing.size_px[i];
    draw_circle(picture, at, radius_px, colour_of(i));
    write_word(picture, track.id, at, radius_px, colour_of(i));
  }
  return image;
}

void write_overlay(const std::filesystem::path& video,
                   const std::filesystem::path& overlay,
                   const TrackDrawing& drawing,
                   double fps,
                   const ProgressCallback& progress) {
  VideoReader reader(video);
  const VideoInfo& info = reader.info();
  VideoWriter writer(
      overlay, info.width_px, info.height_px, {.fps = fps, .crf = kCrf, .quick = true});
  const double total = static_cast<double>(info.declared_frames.value_or(0));
  std::size_t n = 0;
  while (const auto frame = reader.read()) {
    writer.write([&](const PicturePlanes& planes) {
      copy_grey(*frame, planes);
      Picture picture = picture_of(planes);
      draw_frame(picture, drawing, n);
    });
    ++n;
    report_progress(progress, {"drawing the tracks", static_cast<double>(n), total, "frames"});
  }
  writer.finish();
}

}  // namespace twang
