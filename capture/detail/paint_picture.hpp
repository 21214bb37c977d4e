// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/video_reader.hpp"
#include "capture/video_writer.hpp"

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include <string>
#include <vector>

namespace twang::detail {

/// OpenCV draws to 2^-kSubpixelBits of a pixel.
inline constexpr int kSubpixelBits = 4;

/// One array that is painted: all three colours, or one plane of a picture that keeps luma apart.
struct Layer {
  cv::Mat pixels;
  int shrink = 1;  ///< pixels of the picture to one of this array
  cv::Scalar (*ink)(const cv::Scalar& rgb) = nullptr;

  /// A place in OpenCV's fractions of a pixel.
  [[nodiscard]] cv::Point fine(const Eigen::Vector2d& px) const;
  [[nodiscard]] int thickness(int px) const;
};
using Picture = std::vector<Layer>;

[[nodiscard]] Picture picture_of(cv::Mat& colour);
[[nodiscard]] Picture picture_of(const PicturePlanes& planes);

/// The film's picture in grey; where it is a row or column larger than the film's, the last one
/// twice.
void copy_grey(const LumaFrame& frame, const PicturePlanes& planes);

void draw_line(Picture& picture,
               const Eigen::Vector2d& from,
               const Eigen::Vector2d& to,
               const cv::Scalar& colour);
void draw_circle(Picture& picture,
                 const Eigen::Vector2d& at,
                 double radius_px,
                 const cv::Scalar& colour);

/// A word beside a place, dark under light so that it reads on any ground, kept in the picture.
void write_word(Picture& picture,
                const std::string& word,
                const Eigen::Vector2d& at,
                double beside_px,
                const cv::Scalar& colour);

}  // namespace twang::detail
