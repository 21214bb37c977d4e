// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/clock_check.hpp"

#include "capture/video_reader.hpp"
#include "capture/video_writer.hpp"
#include "core/constants.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace twang::test {
namespace {

/// A light as a camera sees it: on for a part of its period, averaged over the exposure.
struct Light {
  double hz = 50.0;
  double duty = 0.5;
  double phase = 0.13;  // of a period
  double exposure_s = 1e-3;

  /// On-time from 0 to t [s].
  [[nodiscard]] double on_until(double t) const {
    const double periods = t * hz + phase;
    const double whole = std::floor(periods);
    return (whole * duty + std::min(periods - whole, duty)) / hz;
  }
  [[nodiscard]] double seen_at(double t) const {
    return (on_until(t + exposure_s) - on_until(t)) / exposure_s;
  }
};

struct Blinking {
  std::vector<double> time_s;
  std::vector<double> brightness;
};

/// Filmed at `fps`; stamps say `claimed_fps`.
Blinking film_of(const Light& light,
                 double fps,
                 int frames,
                 double claimed_fps,
                 double noise = 0.3,
                 unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, noise);
  Blinking film;
  for (int n = 0; n < frames; ++n) {
    film.time_s.push_back(n / claimed_fps);
    film.brightness.push_back(40.0 + 120.0 * light.seen_at(n / fps) + normal(random));
  }
  return film;
}

ClockCheck check_of(const Blinking& film, double hz) {
  return check_clock(film.time_s, film.brightness, hz);
}

TEST(ClockCheck, ARightClockIsFoundRightForEveryDutyAndRate) {
  // Also where harmonics fold back upon the fundamental: 48 and 60 of 240.
  for (const double hz : {7.3, 20.0, 48.0, 50.0, 60.0, 97.0}) {
    for (const double duty : {0.1, 0.3, 0.5, 0.8}) {
      // The phase shows the shortest flash to some frame of every period.
      const Light light{.hz = hz, .duty = duty, .phase = 0.03, .exposure_s = 2e-3};
      const ClockCheck check = check_of(film_of(light, 240.0, 720, 240.0), hz);
      ASSERT_TRUE(check.found) << hz << " " << duty << " " << check.message;
      // Harmonics of sharp edges beyond the ninth fold back near the fundamental: half of what a
      // warning takes.
      EXPECT_NEAR(check.deviation_rel, 0.0, 5e-4) << hz << " " << duty;
      EXPECT_LT(check.sigma_hz / hz, 1e-3) << hz << " " << duty;
      EXPECT_EQ(check.warning, "") << hz << " " << duty;
    }
  }
}

TEST(ClockCheck, SigmaCoversTheError) {
  // A smooth light without folded harmonics: the closed form of a sinusoid's frequency in noise is
  // sigma_f = sqrt(6 / N) noise / (pi A T).
  double sum = 0.0;
  constexpr int kFilms = 30;
  constexpr double kNoise = 3.0;
  constexpr int kFrames = 480;
  for (unsigned seed = 0; seed < kFilms; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, kNoise);
    Blinking film;
    for (int n = 0; n < kFrames; ++n) {
      const double t = n / 240.0;
      film.time_s.push_back(t);
      film.brightness.push_back(100.0 + 30.0 * std::sin(kTwoPi * 31.7 * t) + normal(random));
    }
    const ClockCheck check = check_of(film, 31.7);
    ASSERT_TRUE(check.found);
    const double expected = std::sqrt(6.0 / kFrames) * kNoise / (kPi * 30.0 * kFrames / 240.0);
    // Other harmonics and the robust noise cost little.
    EXPECT_NEAR(check.sigma_hz / expected, 1.0, 0.25);
    sum += std::pow((check.measured_hz - 31.7) / check.sigma_hz, 2);
  }
  // rms of 30 normal errors over their sigma: 1 +- 0.13.
  EXPECT_NEAR(std::sqrt(sum / kFilms), 1.0, 0.4);
}

TEST(ClockCheck, ASmallDeviationIsMeasured) {
  for (const double factor : {1.0005, 0.9995, 1.004}) {
    const Light light{.hz = 50.0, .duty = 0.4, .exposure_s = 3e-3};
    const ClockCheck check = check_of(film_of(light, 240.0, 1440, 240.0 * factor), 50.0);
    ASSERT_TRUE(check.found);
    EXPECT_NEAR(check.deviation_rel, factor - 1.0, 1e-4);
    EXPECT_EQ(check.warning.empty(), factor != 1.004) << check.warning;
  }
}

TEST(ClockCheck, NamesSlowMotionAndTelevisionRates) {
  const Light light{.hz = 12.0, .duty = 0.5};
  const ClockCheck slow = check_of(film_of(light, 240.0, 960, 30.0), 12.0);
  ASSERT_TRUE(slow.found);
  EXPECT_NEAR(slow.measured_hz, 1.5, 2e-3);
  EXPECT_TRUE(holds(slow.warning, "slow motion, 8 times slower than filmed: --capture-fps 24"));
  const ClockCheck tv = check_of(film_of(light, 240.0 / 1.001, 4800, 240.2), 12.0);
  ASSERT_TRUE(tv.found);
  EXPECT_TRUE(holds(tv.warning, "wrong"));
  const Light fast{.hz = 50.0, .duty = 0.5, .exposure_s = 3e-3};
  const ClockCheck tv2 = check_of(film_of(fast, 240.0 / 1.00102, 4800, 240.0), 50.0);
  EXPECT_TRUE(holds(tv2.warning, "television"));
}

TEST(ClockCheck, AHandBeforeTheLightDoesNoHarm) {
  const Light light{.hz = 25.0, .duty = 0.5, .exposure_s = 3e-3};
  Blinking film = film_of(light, 240.0, 960, 240.0);
  for (std::size_t n = 300; n < 420; ++n) film.brightness[n] = 215.0;
  for (std::size_t n = 600; n < 630; ++n) film.brightness[n] = kNaN;
  const ClockCheck check = check_of(film, 25.0);
  ASSERT_TRUE(check.found);
  EXPECT_NEAR(check.deviation_rel, 0.0, 3e-4);
}

TEST(ClockCheck, FindsNothingWhereNothingBlinks) {
  Blinking film = film_of({.hz = 25.0, .duty = 1.0}, 240.0, 480, 240.0);
  EXPECT_FALSE(check_of(film, 25.0).found);
  EXPECT_TRUE(holds(check_of(film, 25.0).message, "no blinking"));
  std::fill(film.brightness.begin(), film.brightness.end(), kNaN);
  EXPECT_FALSE(check_of(film, 25.0).found);
}

TEST(ClockCheck, RefusesARateBeyondHalfTheFrameRate) {
  const Blinking film = film_of({.hz = 50.0}, 240.0, 480, 240.0);
  EXPECT_TRUE(holds(refusal_of([&] { (void)check_of(film, 121.0); }), "the rate is 121 Hz"));
}

TEST(ClockCheck, RefusesRegionsThatAreNone) {
  const auto refusal = [](BlinkingLight light) { return refusal_of([&] { light.check(); }); };
  EXPECT_TRUE(holds(refusal({-1.0, 0.0, 4.0, 4.0, 50.0}), "x is -1"));
  EXPECT_TRUE(holds(refusal({0.0, kNaN, 4.0, 4.0, 50.0}), "y is nan"));
  EXPECT_TRUE(holds(refusal({0.0, 0.0, 0.5, 4.0, 50.0}), "width is 0.5"));
  EXPECT_TRUE(holds(refusal({0.0, 0.0, 4.0, 0.0, 50.0}), "height is 0"));
  EXPECT_TRUE(holds(refusal({0.0, 0.0, 4.0, 4.0, 0.0}), "rate is 0"));
  const std::vector<std::uint8_t> pixels(64 * 48, 9);
  const LumaFrame frame{pixels.data(), 64, 64, 48, 0.0};
  EXPECT_EQ(mean_brightness(frame, {60.0, 40.0, 4.0, 8.0, 50.0}), 9.0);
  EXPECT_TRUE(holds(refusal_of([&] {
                      (void)mean_brightness(frame, {60.0, 40.0, 5.0, 8.0, 50.0});
                    }),
                    "65"));
}

TEST(ClockCheck, MeasuresASquarePaintedIntoAFilm) {
  const TemporaryFolder folder;
  const auto path = folder / "light.mp4";
  const Light light{.hz = 33.0, .duty = 0.35, .exposure_s = 2e-3};
  const BlinkingLight region{20.0, 10.0, 12.0, 12.0, 33.0};
  {
    VideoWriter writer(path, 64, 48, {.fps = 240.0, .crf = 18});
    std::mt19937 random(5);
    for (int n = 0; n < 480; ++n) {
      Image image{64, 48, 1, std::vector<std::uint8_t>(64 * 48)};
      for (auto& pixel : image.pixels) pixel = static_cast<std::uint8_t>(90 + random() % 5);
      for (int y = 12; y < 20; ++y) {
        for (int x = 22; x < 30; ++x) {
          image.pixels[static_cast<std::size_t>(y * 64 + x)] =
              static_cast<std::uint8_t>(std::lround(60.0 + 180.0 * light.seen_at(n / 240.0)));
        }
      }
      writer.write(image);
    }
    writer.finish();
  }
  Blinking film;
  VideoReader reader(path);
  while (const auto frame = reader.read()) {
    film.time_s.push_back(frame->stamp_s);
    film.brightness.push_back(mean_brightness(*frame, region));
  }
  const ClockCheck check = check_of(film, 33.0);
  ASSERT_TRUE(check.found) << check.message;
  EXPECT_NEAR(check.deviation_rel, 0.0, std::max(4.0 * check.sigma_hz / 33.0, 2e-4));
  EXPECT_LT(check.sigma_hz / 33.0, 1e-3);
  EXPECT_EQ(check.warning, "");
}

}  // namespace
}  // namespace twang::test
