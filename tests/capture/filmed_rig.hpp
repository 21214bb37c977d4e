// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"
#include "capture/render_film.hpp"
#include "capture/video_reader.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace twang::test {

/// A bench of 80 x 40 mm with a dot near each corner, coplanar with one marker in the middle that
/// is not fixed; seen along +y, z up.
inline Rig bench_with(MarkerKind kind) {
  Rig rig;
  rig.name = "bench";
  rig.camera = Camera{};
  const auto add = [&](const char* id, MarkerKind picture, double x, double z, bool fixed) {
    Marker marker;
    marker.id = id;
    marker.kind = picture;
    marker.size_m = 8e-3;
    marker.position = {x, 0.0, z};
    marker.fixed = fixed;
    rig.markers.push_back(marker);
  };
  add("middle", kind, 3e-3, 1.7e-3, false);
  add("upper left", MarkerKind::Dot, -40e-3, 20.3e-3, true);
  add("upper right", MarkerKind::Dot, 41.1e-3, 21e-3, true);
  add("lower right", MarkerKind::Dot, 38e-3, -19.2e-3, true);
  add("lower left", MarkerKind::Dot, -37.7e-3, -20e-3, true);
  return rig;
}

/// Every marker at rest.
inline FilmedState at_rest(const Rig& rig) {
  FilmedState state;
  for (const Marker& marker : rig.markers) state.markers.push_back({marker.position, 0.0});
  return state;
}

/// A small film without noise or loss, nothing but the given frames.
inline FilmOptions clean_film(int frames) {
  FilmOptions options;
  options.width_px = 320;
  options.height_px = 180;
  options.duration_s = frames / options.fps;
  options.noise = 0.0;
  options.crf = 0;
  return options;
}

inline std::vector<Image> read_film(const std::filesystem::path& path) {
  VideoReader reader(path);
  std::vector<Image> images;
  while (const auto frame = reader.read()) {
    Image& image = images.emplace_back(Image{frame->width_px, frame->height_px, 1, {}});
    for (int y = 0; y < frame->height_px; ++y) {
      const std::uint8_t* row = frame->pixels + y * frame->stride;
      image.pixels.insert(image.pixels.end(), row, row + frame->width_px);
    }
  }
  return images;
}

inline int pixel_at(const Image& image, int x, int y) {
  return image.pixels[static_cast<std::size_t>(y * image.width_px + x)];
}

/// Where the ink around a place is, and how it spreads in x and y.
struct InkMoments {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d variance_px2 = Eigen::Vector2d::Zero();
};

/// Moments of (paper - grey) in a window that ends on the white paper.
inline InkMoments ink_moments(const Image& image,
                              const Eigen::Vector2d& near_px,
                              double half_width_px) {
  constexpr double kPaper = 220.0;
  double mass = 0.0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Vector2d second = Eigen::Vector2d::Zero();
  const auto bound = [&](double value) { return static_cast<int>(std::lround(value)); };
  for (int y = bound(near_px.y() - half_width_px); y <= bound(near_px.y() + half_width_px); ++y) {
    for (int x = bound(near_px.x() - half_width_px); x <= bound(near_px.x() + half_width_px); ++x) {
      const double ink = kPaper - pixel_at(image, x, y);
      const Eigen::Vector2d at(x, y);
      mass += ink;
      first += ink * at;
      second += ink * at.cwiseAbs2();
    }
  }
  first /= mass;
  return {first, second / mass - first.cwiseAbs2()};
}

}  // namespace twang::test
