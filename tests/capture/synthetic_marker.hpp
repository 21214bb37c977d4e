// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"
#include "capture/marker_pattern.hpp"

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace twang::test {

/// A marker painted into a picture of its own by brute force: every pixel is the mean of many
/// samples of the sharp pattern. Shares only `MarkerPattern::value` with what it tests.
struct PaintedMarker {
  MarkerPattern pattern = MarkerPattern(MarkerKind::Cross);
  Eigen::Vector2d position_px = {32.0, 32.0};
  Eigen::Matrix2d px_from_pattern = 30.0 * Eigen::Matrix2d::Identity();
  Eigen::Vector2d motion_px = Eigen::Vector2d::Zero();  ///< during the exposure
  double paper_sizes = 1.5;                             ///< side of the paper square
  double ink = 25.0, paper = 225.0, background = 90.0;  ///< grey levels
  double shading = 0.0;  ///< relative slope of the paper's brightness, per marker size
  double blur_px = 0.0;  ///< Gaussian defocus, by sampling its kernel
  double noise = 0.0;    ///< standard deviation [grey levels]
};

/// Grey level of the sharp scene at an offset from the marker's centre [px].
inline double sharp_grey(const PaintedMarker& m,
                         const Eigen::Matrix2d& pattern_from_px,
                         const Eigen::Vector2d& offset) {
  const Eigen::Vector2d uv = pattern_from_px * offset;
  if (uv.cwiseAbs().maxCoeff() > 0.5 * m.paper_sizes) {
    return offset.x() > 0.0 ? m.background : 0.5 * m.background;  // an uneven background
  }
  const double paper = m.paper * (1.0 + m.shading * uv.x());
  return m.ink + (paper - m.ink) * m.pattern.value(uv.x(), uv.y());
}

inline Image paint(const PaintedMarker& m, int width, int height, unsigned seed) {
  constexpr int kAcross = 8;  // samples along a pixel's side
  constexpr int kKernel = 5;  // samples of the defocus, along each axis
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, m.noise);
  // Midpoints of equal parts of a Gaussian's area.
  const double parts[kKernel] = {-1.2816, -0.5244, 0.0, 0.5244, 1.2816};
  double variance = 0.0;
  for (const double part : parts) variance += part * part / kKernel;
  const Eigen::Matrix2d pattern_from_px = m.px_from_pattern.inverse();
  const int kernel = m.blur_px > 0.0 ? kKernel : 1;
  const int steps = 1 + static_cast<int>(std::ceil(2.0 * m.motion_px.norm()));
  Image image{width, height, 1, {}};
  image.pixels.reserve(static_cast<std::size_t>(width * height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      double count = 0.0;
      for (int s = 0; s < kAcross * kAcross; ++s) {
        const Eigen::Vector2d at(x - 0.5 + (s % kAcross + 0.5) / kAcross,
                                 y - 0.5 + (s / kAcross + 0.5) / kAcross);
        for (int k = 0; k < kernel * kernel; ++k) {
          Eigen::Vector2d blurred = at - m.position_px;
          if (kernel > 1) {
            blurred += m.blur_px / std::sqrt(variance) *
                       Eigen::Vector2d(parts[k % kKernel], parts[k / kKernel]);
          }
          for (int i = 0; i < steps; ++i) {
            sum +=
                sharp_grey(m, pattern_from_px, blurred - ((i + 0.5) / steps - 0.5) * m.motion_px);
            count += 1.0;
          }
        }
      }
      const double grey = sum / count + noise(random);
      image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::round(grey), 0.0, 255.0)));
    }
  }
  return image;
}

/// The same picture with other noise, without painting it anew.
inline Image with_noise(const Image& clean, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, sigma);
  Image noisy = clean;
  for (std::uint8_t& pixel : noisy.pixels) {
    pixel = static_cast<std::uint8_t>(std::clamp(std::round(pixel + noise(random)), 0.0, 255.0));
  }
  return noisy;
}

}  // namespace twang::test
