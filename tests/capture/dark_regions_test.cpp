// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/dark_regions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace twang::test {
namespace {

using detail::DarkRegion;

struct Mask {
  int width;
  int height;
  std::ptrdiff_t stride;
  std::vector<std::uint8_t> pixels;
  [[nodiscard]] bool marked(int x, int y) const {
    return x >= 0 && y >= 0 && x < width && y < height &&
           pixels[static_cast<std::size_t>(y * stride + x)] == 255;
  }
};

Mask random_mask(int width, int height, double density, unsigned seed) {
  std::mt19937 random(seed);
  std::bernoulli_distribution dark(density);
  Mask mask{width, height, width + 5, {}};
  // What lies between the rows is no part of the picture.
  mask.pixels.assign(static_cast<std::size_t>(mask.stride * height), 255);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      mask.pixels[static_cast<std::size_t>(y * mask.stride + x)] = dark(random) ? 255 : 0;
    }
  }
  return mask;
}

/// Pixel by pixel, from each that is not yet reached.
std::vector<DarkRegion> flooded(const Mask& mask) {
  std::vector<bool> reached(mask.pixels.size(), false);
  std::vector<DarkRegion> regions;
  for (int y0 = 0; y0 < mask.height; ++y0) {
    for (int x0 = 0; x0 < mask.width; ++x0) {
      std::vector<Eigen::Vector2i> reach;
      const auto visit = [&](int x, int y) {
        const auto at = static_cast<std::size_t>(y * mask.stride + x);
        if (!mask.marked(x, y) || reached[at]) return;
        reached[at] = true;
        reach.emplace_back(x, y);
      };
      visit(x0, y0);
      for (std::size_t i = 0; i < reach.size(); ++i) {
        const Eigen::Vector2i at = reach[i];
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) visit(at.x() + dx, at.y() + dy);
        }
      }
      if (reach.empty()) continue;
      Eigen::Vector2i low = reach.front();
      Eigen::Vector2i high = reach.front();
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      for (const Eigen::Vector2i& at : reach) {
        low = low.cwiseMin(at);
        high = high.cwiseMax(at);
        sum += at.cast<double>();
      }
      const auto area = static_cast<long>(reach.size());
      regions.push_back({low.x(),
                         low.y(),
                         high.x() - low.x() + 1,
                         high.y() - low.y() + 1,
                         area,
                         sum / static_cast<double>(area)});
    }
  }
  return regions;
}

TEST(DarkRegions, AreThoseThatAFloodReaches) {
  int num_regions = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const double density = 0.1 + 0.01 * seed;
    const Mask mask = random_mask(40 + static_cast<int>(seed), 30, density, seed);
    const std::vector<DarkRegion> expected = flooded(mask);
    const std::vector<DarkRegion> found =
        detail::dark_regions(mask.pixels.data(), mask.stride, mask.width, mask.height);
    ASSERT_EQ(found.size(), expected.size()) << seed;
    num_regions += static_cast<int>(found.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].left, expected[i].left) << seed << " " << i;
      EXPECT_EQ(found[i].top, expected[i].top) << seed << " " << i;
      EXPECT_EQ(found[i].width_px, expected[i].width_px) << seed << " " << i;
      EXPECT_EQ(found[i].height_px, expected[i].height_px) << seed << " " << i;
      EXPECT_EQ(found[i].area_px, expected[i].area_px) << seed << " " << i;
      // Sums of whole numbers, rounded once.
      EXPECT_LT((found[i].centre_px - expected[i].centre_px).norm(), 1e-12) << seed << " " << i;
    }
  }
  EXPECT_GT(num_regions, 1000);
}

}  // namespace
}  // namespace twang::test
