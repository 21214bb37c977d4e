// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/doubled_frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>
#include <vector>

namespace twang::test {
namespace {

using detail::Likeness;

struct Picture {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> pixels;
};

/// A grey ramp with sensor noise up to so many levels either way, times a gain.
Picture ramp(int width_px, int height_px, int noise, double gain, std::mt19937& random) {
  Picture picture{width_px, height_px, {}};
  const unsigned levels = 2 * static_cast<unsigned>(noise) + 1;
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      const double level =
          gain * (80.0 + 100.0 * x / width_px) + static_cast<double>(random() % levels) - noise;
      picture.pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L)));
    }
  }
  return picture;
}

/// Something black, 16 px wide, somewhere in the picture.
void paint_bar(Picture& picture, int x0) {
  for (int y = picture.height_px / 4; y < picture.height_px / 2; ++y) {
    for (int x = x0; x < x0 + 16; ++x) {
      picture.pixels[static_cast<std::size_t>(y * picture.width_px + x)] = 20;
    }
  }
}

std::vector<Likeness> likeness_of(int frames, const std::function<Picture(int frame)>& picture_at) {
  detail::DoubledFrames doubled;
  for (int n = 0; n < frames; ++n) {
    const Picture picture = picture_at(n);
    doubled.add(
        {picture.pixels.data(), picture.width_px, picture.width_px, picture.height_px, 0.0});
  }
  return doubled.decide();
}

TEST(CompareBlocks, AgreesWithPixelByPixelAndKeepsThePicture) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> level(0, 255);
  std::bernoulli_distribution same(0.5);
  constexpr int kWidth = 3 * detail::kBlock_px + 5;  // the last five are left out
  for (const int rows : {1, 4, detail::kBlock_px}) {
    const auto block_pixels = static_cast<std::size_t>(rows * detail::kBlock_px);
    std::vector<std::uint8_t> now(static_cast<std::size_t>(rows * kWidth));
    for (std::uint8_t& pixel : now) pixel = static_cast<std::uint8_t>(level(random));
    std::vector<detail::BlockSums> expected(3), blocks(3);
    std::vector<std::uint8_t> before, picture;
    for (std::size_t i = 0; i < 3 * block_pixels; ++i) {
      const std::size_t block = i / block_pixels;
      const std::size_t row = i % block_pixels / 16;
      const std::uint8_t pixel = now[row * kWidth + 16 * block + i % 16];
      picture.push_back(pixel);
      before.push_back(same(random) ? pixel : static_cast<std::uint8_t>(level(random)));
      expected[block].light += pixel;
      expected[block].change += static_cast<std::uint32_t>(std::abs(pixel - before[i]));
      expected[block].unequal += pixel != before[i] ? 1 : 0;
    }
    detail::compare_blocks(now.data(), kWidth, rows, before.data(), blocks);
    for (std::size_t block = 0; block < 3; ++block) {
      EXPECT_EQ(blocks[block].light, expected[block].light);
      EXPECT_EQ(blocks[block].change, expected[block].change);
      EXPECT_EQ(blocks[block].unequal, expected[block].unequal);
    }
    EXPECT_EQ(before, picture);
  }
}

class DoubledFrames : public ::testing::TestWithParam<int> {};  // width of the picture

TEST_P(DoubledFrames, NoiseTellsARepeatFromAStillPicture) {
  std::mt19937 random(5);
  Picture last;
  const auto repeats = [](int n) { return n == 9 || n == 10 || n == 24; };
  const std::vector<Likeness> likeness = likeness_of(30, [&](int n) {
    if (!repeats(n)) last = ramp(GetParam(), GetParam() / 2, 3, 1.0, random);
    return last;
  });
  for (int n = 0; n < 30; ++n) {
    EXPECT_EQ(likeness[static_cast<std::size_t>(n)],
              repeats(n) ? Likeness::Same : Likeness::Different)
        << n;
  }
}

TEST_P(DoubledFrames, NoiseThatACoderKeepsNowAndThenTellsNothing) {
  // Of each picture it takes over a part of the last one, here more, there less.
  std::mt19937 random(8);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  Picture last = ramp(GetParam(), GetParam() / 2, 3, 1.0, random);
  const std::vector<Likeness> likeness = likeness_of(60, [&](int) {
    const Picture fresh = ramp(GetParam(), GetParam() / 2, 3, 1.0, random);
    const double part = std::pow(any(random), 2.0);
    for (std::size_t i = 0; i < fresh.pixels.size(); ++i) {
      if (any(random) < part) last.pixels[i] = fresh.pixels[i];
    }
    return last;
  });
  EXPECT_EQ(std::count(likeness.begin(), likeness.end(), Likeness::Same), 0);
}

TEST_P(DoubledFrames, StretchWithoutNoiseIsNoRowOfRepeats) {
  // A coder takes nearly all of the noise away until its next key frame brings it back.
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  Picture last;
  const std::vector<Likeness> likeness = likeness_of(90, [&](int n) {
    const Picture fresh = ramp(GetParam(), GetParam() / 2, 3, 1.0, random);
    if (n <= 30 || n >= 60) return last = fresh;
    for (std::size_t i = 0; i < fresh.pixels.size(); ++i) {
      if (any(random) < 0.05) last.pixels[i] = fresh.pixels[i];
    }
    return last;
  });
  for (std::size_t n = 31; n < 60; ++n) EXPECT_NE(likeness[n], Likeness::Same) << n;
}

TEST_P(DoubledFrames, FramesShownThriceAreTold) {
  std::mt19937 random(6);
  Picture last;
  const std::vector<Likeness> likeness = likeness_of(45, [&](int n) {
    if (n % 3 == 0) last = ramp(GetParam(), GetParam() / 2, 3, 1.0, random);
    return last;
  });
  for (std::size_t n = 0; n < 45; ++n) {
    EXPECT_EQ(likeness[n], n % 3 == 0 ? Likeness::Different : Likeness::Same) << n;
  }
}

TEST_P(DoubledFrames, WithoutNoiseAStillPictureIsNoMoreThanAlike) {
  std::mt19937 random(7);
  const std::vector<Likeness> likeness = likeness_of(30, [&](int n) {
    Picture picture = ramp(GetParam(), GetParam() / 2, 0, 1.0, random);
    paint_bar(picture, n < 15 ? 40 : 2 * n);
    return picture;
  });
  for (std::size_t n = 1; n < 30; ++n) {
    EXPECT_EQ(likeness[n], n < 15 ? Likeness::Alike : Likeness::Different) << n;
  }
}

TEST_P(DoubledFrames, WhitePaperWithoutNoiseDoesNotHideTheNoiseBesideIt) {
  std::mt19937 random(8);
  Picture last;
  const std::vector<Likeness> likeness = likeness_of(30, [&](int n) {
    if (n != 20) {
      last = ramp(GetParam(), GetParam() / 2, 3, 1.0, random);
      for (std::size_t i = 0; i < last.pixels.size() / 2; ++i) last.pixels[i] = 255;
    }
    return last;
  });
  for (std::size_t n = 1; n < 30; ++n) {
    EXPECT_EQ(likeness[n], n == 20 ? Likeness::Same : Likeness::Different) << n;
  }
}

TEST_P(DoubledFrames, FlickerIsNoNoise) {
  // Compressed without noise under a lamp whose ripple repeats every six frames, two of them alike.
  std::mt19937 random(9);
  const std::vector<Likeness> likeness = likeness_of(60, [&](int n) {
    const double gain = 1.0 + 0.1 * std::sin(3.14159265358979 / 3.0 * n + 0.5235987756);
    return ramp(GetParam(), GetParam() / 2, 0, gain, random);
  });
  for (std::size_t n = 1; n < 60; ++n) EXPECT_NE(likeness[n], Likeness::Same) << n;
}

// A small picture is compared whole, in a large one every fourth row.
INSTANTIATE_TEST_SUITE_P(Sizes, DoubledFrames, ::testing::Values(160, 1030));

}  // namespace
}  // namespace twang::test
