// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/search_marker.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace twang {
namespace {

using detail::MarkerPeak;
using detail::search_marker;

struct Scene {
  MarkerPattern pattern;
  double size_px;
  std::vector<MarkerPlacement> markers;
};

/// Markers on white paper, in noise.
Image paint(const Scene& scene, int side, std::mt19937& random) {
  const MarkerTemplate ideal(scene.pattern, scene.size_px, 0.9);
  std::normal_distribution<double> noise(0.0, 3.0);
  Image image{side, side, 1, {}};
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      double value = 1.0;
      for (const MarkerPlacement& marker : scene.markers) {
        const Eigen::Vector2d uv =
            marker.px_from_pattern.inverse() * (Eigen::Vector2d(x, y) - marker.position_px);
        if (uv.cwiseAbs().maxCoeff() < 0.6) value = std::min(value, ideal.at(uv.x(), uv.y()).value);
      }
      const double grey = std::round(30.0 + 180.0 * value + noise(random));
      image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0)));
    }
  }
  return image;
}

class SearchMarker : public testing::TestWithParam<MarkerKind> {};

TEST_P(SearchMarker, FindsInALargeAreaWhatASmallOneShows) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anything(-1.0, 1.0);
  const MarkerPattern pattern(GetParam());
  // About the sizes from which the picture is shrunk by 2, 3 and 4.
  for (const double size_px : {14.0, 21.0, 33.0, 40.5, 57.0}) {
    const int side = static_cast<int>(8.0 * size_px);
    Scene scene{pattern, size_px, {}};
    for (const double x : {0.2, 0.5, 0.8}) {
      scene.markers.push_back(upright_marker(
          {x * side + 2.0 * anything(random), (0.3 + 0.4 * x) * side + 2.0 * anything(random)},
          size_px));
    }
    const Image image = paint(scene, side, random);
    const LumaFrame frame = luma_view(image);
    const MarkerTemplate marker(pattern, size_px, 0.7);
    const Eigen::Matrix2d& shape = scene.markers.front().px_from_pattern;
    std::vector<MarkerPeak> near;
    for (const MarkerPlacement& placed : scene.markers) {
      const auto peaks = search_marker(frame, marker, shape, placed.position_px, 3.0, 0.1);
      ASSERT_FALSE(peaks.empty());
      near.push_back(peaks.front());
    }
    double least = 1.0;
    for (const MarkerPeak& peak : near) least = std::min(least, peak.correlation);
    // A correlation is repeated to the rounding of the transform behind it.
    const auto found = search_marker(
        frame, marker, shape, Eigen::Vector2d::Constant(0.5 * side), 0.5 * side, least - 1e-4);
    ASSERT_EQ(found.size(), near.size()) << size_px;
    for (std::size_t k = 1; k < found.size(); ++k) {
      EXPECT_GE(found[k - 1].correlation, found[k].correlation);
    }
    for (const MarkerPeak& peak : near) {
      EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const MarkerPeak& other) {
        return other.position_px == peak.position_px &&
               std::abs(other.correlation - peak.correlation) < 1e-4;
      })) << size_px;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds,
    SearchMarker,
    testing::Values(MarkerKind::Cross, MarkerKind::Dot, MarkerKind::Ring, MarkerKind::Checker));

}  // namespace
}  // namespace twang
