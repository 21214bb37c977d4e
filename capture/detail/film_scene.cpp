// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/film_scene.hpp"

#include "core/constants.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang::detail {
namespace {

// Grey levels of linear light, 0..255.
constexpr double kInk = 30.0;
constexpr double kPaper = 220.0;
constexpr double kPart = 120.0;
constexpr double kBench = 185.0;
constexpr double kBenchGradient = 10.0;  // from the middle to the edge
constexpr double kBenchTexture = 2.5;    // amplitude of each wave

constexpr double kPaperHalf = 0.5 * kPaperSide;
constexpr double kEdgeOn = 1e-2;    // twice the area of a face that is not worth filling [px²]
constexpr int kMaskSamples = 4;     // per pixel and direction, of the silhouette
constexpr double kUniform = 1e-9;   // part of an area that is rounding, not a second tone
constexpr int kPatternSamples = 4;  // per pixel and direction, of a marker

PixelBox clip(double x0, double y0, double x1, double y1, const Canvas& canvas) {
  const auto pixel = [](double value, int limit) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(limit)));
  };
  return {pixel(std::floor(x0), canvas.width),
          pixel(std::floor(y0), canvas.height),
          pixel(std::ceil(x1) + 1.0, canvas.width),
          pixel(std::ceil(y1) + 1.0, canvas.height)};
}

/// Part of the interval of length `width` around `x` that lies within [-half, half].
double covered(double x, double width, double half) {
  return std::clamp(
      (std::min(x + 0.5 * width, half) - std::max(x - 0.5 * width, -half)) / width, 0.0, 1.0);
}

/// Whether a face covers next to nothing; its neighbours' edges then stand for it.
bool seen_edge_on(const ProjectedFace& face) {
  const Eigen::Vector2d a = face[2] - face[0];
  const Eigen::Vector2d b = face[3] - face[1];
  const Eigen::Vector2d c = face[1] - face[0];
  const Eigen::Vector2d d = face[2] - face[3];
  const auto cross = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
    return std::abs(p.x() * q.y() - p.y() * q.x());
  };
  return cross(a, b) < kEdgeOn && cross(c, a) < kEdgeOn && cross(d, a) < kEdgeOn;
}

/// Marks the samples of `mask` whose centres lie in a triangle. The mask covers `box`,
/// kMaskSamples² samples a pixel.
void fill_triangle(std::array<Eigen::Vector2d, 3> corner,
                   const PixelBox& box,
                   std::vector<std::uint8_t>& mask) {
  const int columns = (box.x1 - box.x0) * kMaskSamples;
  const int rows = (box.y1 - box.y0) * kMaskSamples;
  // Sample (i, j) has its centre at pixel coordinate box.x0 - 1/2 + (i + 1/2) / kMaskSamples.
  for (Eigen::Vector2d& c : corner) {
    c = (c - Eigen::Vector2d(box.x0 - 0.5, box.y0 - 0.5)) * kMaskSamples -
        Eigen::Vector2d::Constant(0.5);
  }
  std::sort(
      corner.begin(), corner.end(), [](const auto& a, const auto& b) { return a.y() < b.y(); });
  const auto& [top, middle, bottom] = corner;
  const int first = std::max(0, static_cast<int>(std::ceil(top.y())));
  const int last = std::min(rows - 1, static_cast<int>(std::floor(bottom.y())));
  const auto crossing = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b, double y) {
    return b.y() > a.y() ? a.x() + (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y()) : a.x();
  };
  for (int j = first; j <= last; ++j) {
    double left = crossing(top, bottom, j);
    double right = j < middle.y() ? crossing(top, middle, j) : crossing(middle, bottom, j);
    if (left > right) std::swap(left, right);
    const int begin = std::max(0, static_cast<int>(std::ceil(left)));
    const int end = std::min(columns - 1, static_cast<int>(std::floor(right)));
    if (end < begin) continue;
    std::fill_n(mask.begin() + static_cast<std::ptrdiff_t>(j) * columns + begin,
                end - begin + 1,
                std::uint8_t{1});
  }
}

std::vector<float> gaussian_kernel(double sigma) {
  const int radius = static_cast<int>(std::ceil(4.0 * sigma));
  std::vector<float> kernel(static_cast<std::size_t>(2 * radius + 1));
  double sum = 0.0;
  for (int i = -radius; i <= radius; ++i) sum += std::exp(-0.5 * i * i / (sigma * sigma));
  for (int i = -radius; i <= radius; ++i) {
    kernel[static_cast<std::size_t>(i + radius)] =
        static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma)) / sum);
  }
  return kernel;
}

}  // namespace

PixelBox PixelBox::united(const PixelBox& other) const {
  if (empty()) return other;
  if (other.empty()) return *this;
  return {std::min(x0, other.x0),
          std::min(y0, other.y0),
          std::max(x1, other.x1),
          std::max(y1, other.y1)};
}

Canvas::Canvas(int width_px, int height_px)
    : width(width_px),
      height(height_px),
      light(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), 0.0F) {}

ProjectedMarker project_marker(const FilmCamera& camera,
                               const MarkerPattern& pattern,
                               double size_m,
                               const MarkerPose& pose,
                               const Eigen::Vector2d& shift_px) {
  // Columns: the pattern's x and y axes after a turn anticlockwise, in (u right, v down).
  Eigen::Matrix2d axes;
  axes << std::cos(pose.turn_rad), std::sin(pose.turn_rad), -std::sin(pose.turn_rad),
      std::cos(pose.turn_rad);
  const Eigen::Matrix2d px_from_pattern = camera.jacobian(pose.position, shift_px) * axes * size_m;
  return {pattern, camera.pixel_from_rig(pose.position, shift_px), px_from_pattern.inverse()};
}

PixelBox box_of(const ProjectedMarker& marker, const Canvas& canvas) {
  const Eigen::Vector2d reach =
      kPaperHalf * marker.pattern_from_px.inverse().cwiseAbs().rowwise().sum();
  const Eigen::Vector2d low = marker.centre_px - reach;
  const Eigen::Vector2d high = marker.centre_px + reach;
  return clip(low.x() - 1.0, low.y() - 1.0, high.x() + 1.0, high.y() + 1.0, canvas);
}

PixelBox box_of(const std::vector<ProjectedFace>& faces, const Canvas& canvas) {
  if (faces.empty()) return {};
  Eigen::Vector2d low = faces.front()[0];
  Eigen::Vector2d high = low;
  for (const ProjectedFace& face : faces) {
    for (const Eigen::Vector2d& corner : face) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  return clip(low.x() - 0.5, low.y() - 0.5, high.x() + 0.5, high.y() + 0.5, canvas);
}

void paint_bench(Canvas& canvas, const FilmCamera& camera, const Eigen::Vector2d& shift_px) {
  const double view = canvas.width / camera.scale_px_per_m();  // [m]
  struct Wave {
    double u, v, phase;  // waves a view width, and where they start
  };
  constexpr std::array<Wave, 3> kWaves = {{{3.1, 1.7, 0.4}, {-2.3, 4.9, 2.1}, {6.7, -3.3, 5.0}}};
  for (int y = 0; y < canvas.height; ++y) {
    float* row = canvas.row(y);
    for (int x = 0; x < canvas.width; ++x) {
      const Eigen::Vector2d at = camera.plane_from_pixel(Eigen::Vector2d(x, y), shift_px) / view;
      double light = kBench + kBenchGradient * (at.x() - at.y());
      for (const Wave& wave : kWaves) {
        light +=
            kBenchTexture * std::sin(kTwoPi * (wave.u * at.x() + wave.v * at.y()) + wave.phase);
      }
      row[x] = static_cast<float>(light);
    }
  }
}

void paint_silhouette(Canvas& canvas,
                      const std::vector<ProjectedFace>& faces,
                      std::vector<std::uint8_t>& mask) {
  const PixelBox box = box_of(faces, canvas);
  if (box.empty()) return;
  const auto columns = static_cast<std::ptrdiff_t>(box.x1 - box.x0) * kMaskSamples;
  mask.assign(static_cast<std::size_t>(columns * (box.y1 - box.y0) * kMaskSamples), 0);
  for (const ProjectedFace& face : faces) {
    if (seen_edge_on(face)) continue;
    fill_triangle({face[0], face[1], face[2]}, box, mask);
    fill_triangle({face[0], face[2], face[3]}, box, mask);
  }
  for (int y = box.y0; y < box.y1; ++y) {
    float* row = canvas.row(y);
    for (int x = box.x0; x < box.x1; ++x) {
      int hits = 0;
      for (int j = 0; j < kMaskSamples; ++j) {
        const std::uint8_t* sample =
            mask.data() + ((y - box.y0) * kMaskSamples + j) * columns + (x - box.x0) * kMaskSamples;
        for (int i = 0; i < kMaskSamples; ++i) hits += sample[i];
      }
      const float cover = static_cast<float>(hits) / (kMaskSamples * kMaskSamples);
      row[x] += cover * (static_cast<float>(kPart) - row[x]);
    }
  }
}

void paint_marker(Canvas& canvas, const ProjectedMarker& marker, bool soft) {
  const PixelBox box = box_of(marker, canvas);
  const double pixel = std::sqrt(std::abs(marker.pattern_from_px.determinant()));
  const double sample = pixel / kPatternSamples;
  const int width_px = soft ? 2 : 1;  // of what a pixel sees
  const int samples = width_px * kPatternSamples;
  // Smooth over a pixel: its mean hardly knows how the pixel is turned.
  const bool texture = marker.pattern.kind() == MarkerKind::Patch;
  // A square of this side around a pixel's centre holds the pixel however it is turned and sheared.
  const double surround =
      2.0 * width_px * marker.pattern_from_px.cwiseAbs().rowwise().sum().maxCoeff();
  for (int y = box.y0; y < box.y1; ++y) {
    float* row = canvas.row(y);
    for (int x = box.x0; x < box.x1; ++x) {
      const Eigen::Vector2d centre =
          marker.pattern_from_px * (Eigen::Vector2d(x, y) - marker.centre_px);
      const double far = centre.cwiseAbs().maxCoeff() + 0.5 * surround;
      if (texture && far < kPaperHalf) {
        const double value = marker.pattern.averaged(centre.x(), centre.y(), pixel);
        row[x] = static_cast<float>(kInk + (kPaper - kInk) * value);
        continue;
      }
      const double around = marker.pattern.averaged(centre.x(), centre.y(), surround);
      if (far < kPaperHalf && std::min(around, 1.0 - around) < kUniform) {
        row[x] = static_cast<float>(around > 0.5 ? kPaper : kInk);
        continue;
      }
      double paper = 0.0;  // part of the pixel
      double light = 0.0;  // of that part
      for (int j = 0; j < samples; ++j) {
        for (int i = 0; i < samples; ++i) {
          const Eigen::Vector2d offset((i + 0.5) / kPatternSamples - 0.5 * width_px,
                                       (j + 0.5) / kPatternSamples - 0.5 * width_px);
          const double weight =
              soft ? (1.0 - std::abs(offset.x())) * (1.0 - std::abs(offset.y())) : 1.0;
          const Eigen::Vector2d at = centre + marker.pattern_from_px * offset;
          const double part = weight * covered(at.x(), sample, kPaperHalf) *
                              covered(at.y(), sample, kPaperHalf) /
                              (kPatternSamples * kPatternSamples);
          if (part <= 0.0) continue;
          const double value = marker.pattern.averaged(at.x(), at.y(), sample);
          paper += part;
          light += part * (kInk + (kPaper - kInk) * value);
        }
      }
      row[x] = static_cast<float>((1.0 - paper) * row[x] + light);
    }
  }
}

void defocus(Canvas& canvas, double sigma_px) {
  if (!(sigma_px > 0.0)) return;
  const std::vector<float> kernel = gaussian_kernel(sigma_px);
  const int radius = static_cast<int>(kernel.size() / 2);
  const int width = canvas.width;
  const int height = canvas.height;
  Canvas across(width, height);
  std::vector<float> padded(static_cast<std::size_t>(width + 2 * radius));
  for (int y = 0; y < height; ++y) {
    const float* row = canvas.row(y);
    std::fill_n(padded.begin(), radius, row[0]);
    std::copy_n(row, width, padded.begin() + radius);
    std::fill_n(padded.begin() + radius + width, radius, row[width - 1]);
    float* target = across.row(y);
    for (std::size_t k = 0; k < kernel.size(); ++k) {
      const float* source = padded.data() + k;
      for (int x = 0; x < width; ++x) target[x] += kernel[k] * source[x];
    }
  }
  for (int y = 0; y < height; ++y) {
    float* target = canvas.row(y);
    std::fill_n(target, width, 0.0F);
    for (int k = -radius; k <= radius; ++k) {
      const float weight = kernel[static_cast<std::size_t>(k + radius)];
      const float* source = across.row(std::clamp(y + k, 0, height - 1));
      for (int x = 0; x < width; ++x) target[x] += weight * source[x];
    }
  }
}

}  // namespace twang::detail
