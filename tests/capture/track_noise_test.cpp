// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/track_noise.hpp"

#include "core/constants.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace twang::test {
namespace {

using Track = std::vector<Eigen::Vector2d>;

/// A marker held still, let go at frame 40, vibrating in two modes about a drifting rest.
Track vibration(int frames, double noise_px, unsigned seed, double amplitude_px = 9.0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> error(0.0, 1.0);
  Track track;
  for (int n = 0; n < frames; ++n) {
    const double t = std::max(0.0, (n - 40) / 240.0);
    const double swing = std::exp(-4.0 * t) * std::cos(kTwoPi * 53.0 * t) +
                         0.1 * std::exp(-9.0 * t) * std::cos(kTwoPi * 97.0 * t);
    track.emplace_back(300.0 + 0.002 * n + 0.2 * amplitude_px * swing + noise_px * error(random),
                       200.0 + amplitude_px * swing + noise_px * error(random));
  }
  return track;
}

TEST(TrackNoise, ScatterOfAVibrationIsTheNoiseThatWasAdded) {
  for (const double noise_px : {0.003, 0.02, 0.1}) {
    const auto measured = detail::measure_track_noise(vibration(300, noise_px, 7));
    ASSERT_TRUE(measured);
    // 260 windows of 32 degrees of freedom that overlap: about 5 %; the kink of the release adds.
    EXPECT_NEAR(measured->scatter_px, noise_px, 0.12 * noise_px);
  }
}

TEST(TrackNoise, ScatterOfAMarkerThatStandsIsItsNoise) {
  const auto measured = detail::measure_track_noise(vibration(300, 0.01, 3, 0.0));
  ASSERT_TRUE(measured);
  EXPECT_NEAR(measured->scatter_px, 0.01, 1e-3);
  EXPECT_LT(measured->motion_px, 0.3);
}

TEST(TrackNoise, OneFrameInTenMissingDoesNotHideIt) {
  Track track = vibration(400, 0.02, 5);
  std::mt19937 random(1);
  std::bernoulli_distribution missing(0.1);
  for (auto& px : track) {
    if (missing(random)) px.setConstant(kNaN);
  }
  const auto measured = detail::measure_track_noise(track);
  ASSERT_TRUE(measured);
  EXPECT_NEAR(measured->scatter_px, 0.02, 5e-3);  // shorter windows, fewer of them
}

TEST(TrackNoise, TooShortATrackSaysNothing) {
  EXPECT_FALSE(detail::measure_track_noise(vibration(50, 0.02, 5)));
  EXPECT_FALSE(detail::measure_track_noise({}));
}

struct Widened {
  std::vector<double> moving, still;
};

Widened widen(const Track& moving, const Track& still, double sigma_px) {
  Widened result{std::vector<double>(moving.size(), sigma_px),
                 std::vector<double>(still.size(), sigma_px)};
  detail::widen_by_scatter({&moving, &still}, {&result.moving, &result.still});
  return result;
}

TEST(TrackNoise, SigmasGrowToTheScatter) {
  const Widened widened = widen(vibration(300, 0.04, 2), vibration(300, 0.002, 9, 0.0), 0.003);
  EXPECT_NEAR(widened.moving[100], 0.04, 5e-3);
  // A marker that stands keeps a part of the others' error, which in it does not scatter.
  EXPECT_GT(widened.still[100], 0.2 * widened.moving[100]);
  EXPECT_LT(widened.still[100], 0.5 * widened.moving[100]);
}

TEST(TrackNoise, HonestSigmasStay) {
  const Widened widened = widen(vibration(300, 0.01, 2), vibration(300, 0.01, 9, 0.0), 0.01);
  EXPECT_NEAR(widened.moving[100], 0.01, 1.5e-3);
  EXPECT_NEAR(widened.still[100], 0.01, 1.5e-3);
}

TEST(TrackNoise, ShortTracksGetTheUsualErrorOfACodec) {
  const Widened widened = widen(vibration(20, 0.01, 2), vibration(20, 0.01, 9, 0.0), 0.003);
  EXPECT_GT(widened.moving[10], 0.015);
}

TEST(TrackNoise, LostSamplesStayLost) {
  Track track = vibration(300, 0.01, 2);
  track[50].setConstant(kNaN);
  std::vector<double> sigma(track.size(), 0.01);
  sigma[50] = kNaN;
  detail::widen_by_scatter({&track}, {&sigma});
  EXPECT_TRUE(std::isnan(sigma[50]));
  EXPECT_TRUE(std::isfinite(sigma[51]));
}

}  // namespace
}  // namespace twang::test
