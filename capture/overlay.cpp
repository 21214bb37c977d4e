// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/overlay.hpp"

#include "capture/detail/paint_film.hpp"
#include "capture/detail/paint_picture.hpp"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

namespace twang {
namespace {

using namespace detail;

// Red, green, blue; told apart by most eyes and on grey.
const std::array kColours = {cv::Scalar(255, 170, 0),
                             cv::Scalar(0, 190, 255),
                             cv::Scalar(120, 230, 60),
                             cv::Scalar(255, 110, 200),
                             cv::Scalar(240, 230, 40),
                             cv::Scalar(150, 140, 255)};
const cv::Scalar kAlarm(255, 40, 40);
constexpr std::size_t kTail = 24;  // frames of path behind a marker
constexpr double kArm = 0.75;      // of a crosshair, over the marker's size [-]
constexpr double kBeside = 0.6;    // from a marker to its name, over its size [-]
constexpr double kRing = 0.85;     // radius of the ring around a marker, over its size [-]
constexpr int kBorder_px = 6;      // around a repeated frame

const cv::Scalar& colour_of(std::size_t marker) { return kColours[marker % kColours.size()]; }

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
  paint_film(
      video,
      overlay,
      {.fps = fps, .stage = "drawing the tracks"},
      [&](Picture& picture, const LumaFrame&, std::size_t n) { draw_frame(picture, drawing, n); },
      progress);
}

}  // namespace twang
