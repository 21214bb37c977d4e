// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/overlay.hpp"

#include "capture/video_reader.hpp"
#include "capture/video_writer.hpp"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>

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

cv::Point fine(const Eigen::Vector2d& px) {
  const double steps = 1 << kShift;
  return {static_cast<int>(std::lround(px.x() * steps)),
          static_cast<int>(std::lround(px.y() * steps))};
}

cv::Mat in_colour(const std::uint8_t* pixels, std::ptrdiff_t stride, int width, int height) {
  // OpenCV's header takes what it only reads as writable.
  const cv::Mat grey(
      height, width, CV_8UC1, const_cast<std::uint8_t*>(pixels), static_cast<std::size_t>(stride));
  cv::Mat colour;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2RGB);
  return colour;
}

Image to_image(const cv::Mat& colour) {
  Image image{colour.cols, colour.rows, 3, {}};
  image.pixels.assign(colour.datastart, colour.dataend);
  return image;
}

const cv::Scalar& colour_of(std::size_t marker) { return kColours[marker % kColours.size()]; }

void draw_path(cv::Mat& picture,
               const std::vector<Eigen::Vector2d>& path,
               std::size_t first,
               std::size_t last,
               const cv::Scalar& colour) {
  for (std::size_t n = first + 1; n <= last && n < path.size(); ++n) {
    if (!path[n].allFinite() || !path[n - 1].allFinite()) continue;
    cv::line(picture, fine(path[n - 1]), fine(path[n]), colour, 1, cv::LINE_AA, kShift);
  }
}

/// A word beside a place, dark under light so that it reads on any ground, kept in the picture.
void write_word(cv::Mat& picture,
                const std::string& word,
                const Eigen::Vector2d& at,
                double beside_px,
                const cv::Scalar& colour) {
  const double scale = std::max(0.4, 0.4 * picture.rows / kTextHeight_px);
  const int thick = std::max(1, static_cast<int>(std::lround(scale)));
  int below = 0;
  const cv::Size size = cv::getTextSize(word, cv::FONT_HERSHEY_SIMPLEX, scale, thick, &below);
  cv::Point origin(static_cast<int>(at.x() + beside_px), static_cast<int>(at.y() - beside_px));
  if (origin.x + size.width > picture.cols) {
    origin.x = static_cast<int>(at.x() - beside_px) - size.width;
  }
  origin.x = std::clamp(origin.x, 0, std::max(0, picture.cols - size.width));
  origin.y = std::clamp(origin.y, size.height, std::max(size.height, picture.rows - below));
  const auto put = [&](const cv::Scalar& ink, int width) {
    cv::putText(picture, word, origin, cv::FONT_HERSHEY_SIMPLEX, scale, ink, width, cv::LINE_AA);
  };
  put(cv::Scalar(0, 0, 0), thick + 2);
  put(colour, thick);
}

void draw_crosshair(cv::Mat& picture,
                    const Eigen::Vector2d& at,
                    double size_px,
                    const cv::Scalar& colour) {
  const double arm = 0.75 * size_px;
  for (const Eigen::Vector2d& way : {Eigen::Vector2d(arm, 0.0), Eigen::Vector2d(0.0, arm)}) {
    cv::line(picture, fine(at - way), fine(at + way), colour, 1, cv::LINE_AA, kShift);
  }
}

cv::Mat draw_frame(const LumaFrame& frame, const TrackDrawing& drawing, std::size_t n) {
  cv::Mat picture = in_colour(frame.pixels, frame.stride, frame.width_px, frame.height_px);
  for (std::size_t i = 0; i < drawing.tracks.size(); ++i) {
    const MarkerTrack& track = drawing.tracks[i];
    draw_path(picture, track.position_px, n > kTail ? n - kTail : 0, n, colour_of(i));
    if (n < track.position_px.size() && track.position_px[n].allFinite()) {
      draw_crosshair(picture, track.position_px[n], drawing.size_px[i], colour_of(i));
      write_word(picture, track.id, track.position_px[n], 0.6 * drawing.size_px[i], colour_of(i));
      continue;
    }
    for (std::size_t back = std::min(n, track.position_px.size()); back-- > 0;) {
      if (!track.position_px[back].allFinite()) continue;
      write_word(picture, track.id + " lost", track.position_px[back], 0.0, kAlarm);
      break;
    }
  }
  if (n < drawing.doubled.size() && drawing.doubled[n]) {
    write_word(picture, "repeated frame", {8.0, 8.0}, 0.0, kAlarm);
  }
  return picture;
}

}  // namespace

Image draw_tracks(const Image& grey, const TrackDrawing& drawing, std::size_t frame) {
  cv::Mat picture = in_colour(grey.pixels.data(), grey.width_px, grey.width_px, grey.height_px);
  for (std::size_t i = 0; i < drawing.tracks.size(); ++i) {
    const MarkerTrack& track = drawing.tracks[i];
    draw_path(picture, track.position_px, 0, track.position_px.size(), colour_of(i));
    const Eigen::Vector2d& at = track.position_px[frame];
    if (!at.allFinite()) continue;
    const double radius = 0.85 * drawing.size_px[i];
    cv::circle(picture,
               fine(at),
               static_cast<int>(radius * (1 << kShift)),
               colour_of(i),
               2,
               cv::LINE_AA,
               kShift);
    write_word(picture, track.id, at, radius, colour_of(i));
  }
  return to_image(picture);
}

void write_overlay(const std::filesystem::path& video,
                   const std::filesystem::path& overlay,
                   const TrackDrawing& drawing,
                   double fps,
                   const ProgressCallback& progress) {
  VideoReader reader(video);
  const VideoInfo& info = reader.info();
  VideoWriter writer(overlay, info.width_px, info.height_px, {.fps = fps});
  const double total = static_cast<double>(info.declared_frames.value_or(0));
  std::size_t n = 0;
  while (const auto frame = reader.read()) {
    writer.write(to_image(draw_frame(*frame, drawing, n)));
    ++n;
    report_progress(progress, {"drawing the tracks", static_cast<double>(n), total, "frames"});
  }
  writer.finish();
}

}  // namespace twang
