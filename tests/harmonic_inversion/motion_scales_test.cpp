// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/motion_scales.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/release.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace twang {
namespace {

TEST(ScalesByUnit, AreTheLargestRangeOfTheUnitAndOnesOwnWithoutOne) {
  Eigen::MatrixXd value(3, 6);
  value.row(0) << 0.0, 0.0, 1.0, 0.0, 0.0, 5.0;
  value.row(1) << 2.0, 9.0, 1.5, 7.0, 30.0, 5.0;
  value.row(2) << 1.0, 8.0, 1.2, 3.0, 20.0, 5.0;
  const Eigen::RowVectorXd scales =
      scales_by_unit(value, {"a.x_mm", "b.x_mm", "turn_rad", "left", "right_1", "constant"});
  Eigen::RowVectorXd expected(6);
  expected << 9.0, 9.0, 0.5, 7.0, 30.0, 1.0;
  EXPECT_EQ(scales, expected);
}

TEST(ScalesByNoise, AreTheNoiseWhileAtRest) {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal(0.0, 0.02);
  Eigen::MatrixXd value(2000, 1);
  for (Eigen::Index i = 0; i < value.rows(); ++i)
    value(i, 0) = normal(generator) + (i < 1000 ? 0.0 : std::sin(0.3 * static_cast<double>(i)));
  // The quartile of all bends is taken, of which half are of the vibration: the median of those at
  // rest, 2.1 times the quartile.
  EXPECT_GT(scales_by_noise(value)(0), 0.02);
  EXPECT_LT(scales_by_noise(value)(0), 2.3 * 0.02);
}

/// Some channels let go at 0.5 s or in free motion from the first sample, and many still ones.
struct Scene {
  double held_s = 0.5;
  int num_moving = 1;
  std::string suffix;      ///< of the channels' names
  double jump = 0.0;       ///< of every fifth still channel, at 0.17 s
  std::uint32_t seed = 1;  ///< of noise and amplitudes
};

constexpr int kChannels = 18;
constexpr double kSwing_hz = 8.0;
constexpr double kDecayPerS = 2.4;

Trace make_trace(const Scene& scene) {
  std::mt19937 generator(scene.seed);
  std::uniform_real_distribution<double> part(0.3, 1.0);
  Trace out;
  for (int c = 0; c < kChannels; ++c) {
    const bool moves = c < scene.num_moving;
    SynthesisOptions options;
    options.duration_s = 3.0;
    options.held_s = scene.held_s;
    options.noise_sigma = 0.02 * (moves ? 1.0 : part(generator));
    options.seed = 100 * scene.seed + static_cast<std::uint32_t>(c);
    options.channel = fmt::format("c{}{}", c, scene.suffix);
    std::vector<SinusoidTruth> truth;
    if (moves) truth = {{kSwing_hz, kDecayPerS, c == 0 ? 1.0 : part(generator), 0.5 * kPi}};
    Trace one = synthesize_sinusoids(truth, options);
    for (std::size_t i = 0; !moves && c % 5 == 4 && i < 40; ++i)
      one.channels[0].values[i] += scene.jump;
    out.time_s = one.time_s;
    out.channels.push_back(std::move(one.channels[0]));
  }
  return out;
}

std::vector<std::string> names_of(const Trace& trace) {
  std::vector<std::string> out;
  for (const Channel& channel : trace.channels) out.push_back(channel.name);
  return out;
}

FreeMotion motion_of_all(const Trace& trace) {
  return find_free_motion(trace, names_of(trace), trace.time_s.front(), trace.time_s.back());
}

TEST(FreeMotionOfManyChannels, IsSeenThoughMostHoldNoiseAlone) {
  for (const char* suffix : {"", "_px"}) {
    for (const int num_moving : {1, 3}) {
      for (std::uint32_t seed = 1; seed <= 5; ++seed) {
        const FreeMotion motion = motion_of_all(make_trace({0.5, num_moving, suffix, 0.0, seed}));
        ASSERT_TRUE(motion.release_s) << num_moving << " of " << kChannels << suffix;
        EXPECT_NEAR(*motion.release_s, 0.5, 0.125 / kSwing_hz + 4.0 / 240.0);
      }
    }
  }
}

TEST(FreeMotionOfManyChannels, IsNotTheJumpOfAMarkerThatIsStillElse) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const FreeMotion motion = motion_of_all(make_trace({0.5, 3, "_px", 0.1, seed}));
    ASSERT_TRUE(motion.release_s);
    EXPECT_NEAR(*motion.release_s, 0.5, 0.125 / kSwing_hz + 4.0 / 240.0);
  }
}

TEST(FreeMotionOfManyChannels, WithoutAHoldBeginsWithTheRecordWhateverTheStillOnesDo) {
  for (const char* suffix : {"", "_px"}) {
    for (const int num_moving : {0, 1, 3}) {
      for (const double jump : {0.0, 0.1}) {
        EXPECT_FALSE(motion_of_all(make_trace({0.0, num_moving, suffix, jump, 1})).release_s)
            << num_moving << " of " << kChannels << suffix << ", jump " << jump;
      }
    }
  }
}

TEST(FreeMotionOfManyChannels, HasTheModeOfTheFewThatMove) {
  const Trace trace = make_trace({0.5, 2, "_mm", 0.1, 3});
  const InversionResult joint = invert_harmonics(trace, names_of(trace));
  ASSERT_EQ(joint.modes.size(), 1U) << joint.message;
  const DampedSinusoid& mode = joint.modes.front();
  EXPECT_NEAR(mode.frequency_hz, kSwing_hz, 4.0 * mode.frequency_sigma_hz);
  EXPECT_NEAR(mode.decay_per_s, kDecayPerS, 4.0 * mode.decay_sigma_per_s);
}

}  // namespace
}  // namespace twang
