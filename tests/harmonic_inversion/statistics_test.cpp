// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>
#include <vector>

namespace twang {
namespace {

/// Cramer-Rao bounds of f [Hz] and d [1/s] for one sinusoid with amplitude, phase and offset free,
/// in white noise: the inverse of J^T J / sigma², J from the formula.
Eigen::Vector2d cramer_rao(const SinusoidTruth& truth, const SynthesisOptions& options) {
  const auto n = static_cast<Eigen::Index>(std::floor(options.duration_s * options.rate_hz)) + 1;
  Eigen::MatrixXd jacobian(n, 5);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / options.rate_hz;
    const double angle = kTwoPi * truth.frequency_hz * t + truth.phase_rad;
    const double envelope = std::exp(-truth.decay_per_s * t);
    const double a = truth.amplitude;
    jacobian.row(i) << a * envelope * std::cos(angle) * kTwoPi * t,
        -a * t * envelope * std::sin(angle), envelope * std::sin(angle),
        a * envelope * std::cos(angle), 1.0;
  }
  const Eigen::MatrixXd covariance =
      (jacobian.transpose() * jacobian).inverse() * (options.noise_sigma * options.noise_sigma);
  return covariance.diagonal().head(2).cwiseSqrt();
}

class CramerRao : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(CramerRao, IsReachedAndTheSigmasAreHonest) {
  const auto [frequency_hz, snr_db] = GetParam();
  const SinusoidTruth truth{frequency_hz, 4.0, 1.0, 0.6};
  SynthesisOptions options;
  options.noise_sigma = std::pow(10.0, -snr_db / 20.0);
  const Eigen::Vector2d bound = cramer_rao(truth, options);
  constexpr int kDraws = 400;
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  int within_one = 0;
  int within_two = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    options.seed = static_cast<std::uint32_t>(1000 + draw);
    const InversionResult result = invert_harmonics(synthesize_sinusoids({truth}, options), {"y"});
    ASSERT_FALSE(result.modes.empty()) << result.message;
    const DampedSinusoid& mode = result.modes.front();
    const Eigen::Vector2d error(mode.frequency_hz - truth.frequency_hz,
                                mode.decay_per_s - truth.decay_per_s);
    const Eigen::Vector2d sigma(mode.frequency_sigma_hz, mode.decay_sigma_per_s);
    squares += error.cwiseAbs2();
    for (int i = 0; i < 2; ++i) {
      within_one += std::abs(error(i)) < sigma(i) ? 1 : 0;
      within_two += std::abs(error(i)) < 2.0 * sigma(i) ? 1 : 0;
    }
  }
  const Eigen::Vector2d rmse = (squares / kDraws).cwiseSqrt();
  // The rmse of 400 draws scatters by 3.5 %; 1.1 times the bound is 3 sigma, 1.15 leaves room for
  // the drift that is fitted in the few draws that seem to have one.
  EXPECT_LT(rmse(0), 1.15 * bound(0));
  EXPECT_LT(rmse(1), 1.15 * bound(1));
  // And no lucky number: the bound cannot be beaten by more than the scatter.
  EXPECT_GT(rmse(0), 0.88 * bound(0));
  EXPECT_GT(rmse(1), 0.88 * bound(1));
  // 68.3 % and 95.4 % of 800, with a scatter of 1.6 % and 0.75 %: three of them.
  EXPECT_NEAR(within_one / (2.0 * kDraws), 0.683, 0.05);
  EXPECT_NEAR(within_two / (2.0 * kDraws), 0.954, 0.023);
}

INSTANTIATE_TEST_SUITE_P(FrequenciesAndNoise,
                         CramerRao,
                         testing::Combine(testing::Values(20.0, 60.0),
                                          testing::Values(30.0, 45.0, 60.0)));

TEST(InvertHarmonics, GivesWhiteNoiseAModeInUnderOnePercentOfTheDraws) {
  for (const double duration_s : {0.25, 2.0}) {
    int alarms = 0;
    constexpr int kDraws = 600;
    for (int draw = 0; draw < kDraws; ++draw) {
      SynthesisOptions options;
      options.noise_sigma = 1.0;
      options.duration_s = duration_s;
      options.seed = static_cast<std::uint32_t>(7000 + draw);
      alarms += invert_harmonics(synthesize_sinusoids({}, options), {"y"}).usable() ? 1 : 0;
    }
    // 1 % of 600 is 6; 12 would be exceeded by a true 1 % in one of a hundred runs, and the seeds
    // are fixed.
    EXPECT_LE(alarms, 6) << "of " << kDraws << " records of " << duration_s << " s";
  }
}

TEST(InvertHarmonics, AddsNoFalseModeToATrueOne) {
  int extra = 0;
  constexpr int kDraws = 200;
  for (int draw = 0; draw < kDraws; ++draw) {
    SynthesisOptions options;
    options.noise_sigma = 0.02;
    options.seed = static_cast<std::uint32_t>(300 + draw);
    const InversionResult result =
        invert_harmonics(synthesize_sinusoids({{22.0, 4.0, 1.0, 0.1}}, options), {"y"});
    extra += static_cast<int>(result.modes.size()) - 1;
  }
  EXPECT_LE(extra, 3);  // 1 % of 200 is 2
}

TEST(InvertHarmonics, FindsAHeldPartsReleaseAndItsMotionWhateverItsFrequency) {
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const double noise : {0.0005, 0.01}) {
    int wrong = 0;
    constexpr int kDraws = 150;
    for (int draw = 0; draw < kDraws; ++draw) {
      const double frequency_hz = 4.0 * std::pow(20.0, uniform(generator));
      const double zeta = 0.01 + 0.1 * uniform(generator);
      const SinusoidTruth truth{frequency_hz, kTwoPi * frequency_hz * zeta, 1.0, 0.5 * kPi};
      SynthesisOptions options;
      options.held_s = 0.1 + 0.1 * uniform(generator);
      options.offset = 3.0 * uniform(generator);
      options.noise_sigma = noise;
      options.seed = static_cast<std::uint32_t>(draw + 1);
      const InversionResult result =
          invert_harmonics(synthesize_sinusoids({truth}, options), {"y"});
      const bool fine = result.release_s && result.modes.size() == 1U &&
                        std::abs(result.modes[0].frequency_hz - truth.frequency_hz) <
                            4.0 * result.modes[0].frequency_sigma_hz &&
                        std::abs(result.modes[0].decay_per_s - truth.decay_per_s) <
                            4.0 * result.modes[0].decay_sigma_per_s;
      wrong += fine ? 0 : 1;
    }
    EXPECT_LE(wrong, 1)
        << noise;  // 300 values beyond 4 sigma: 0.02 expected; one false mode may be
  }
}

TEST(InvertHarmonics, FindsTwoModesOnJitteredStampsWithGapsAndNoThird) {
  std::mt19937 generator(8);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const double noise : {0.001, 0.05}) {
    int wrong = 0;
    for (int draw = 0; draw < 100; ++draw) {
      const double low_hz = 8.0 + 14.0 * uniform(generator);
      const double high_hz = low_hz * (1.5 + 3.0 * uniform(generator));
      SynthesisOptions options;
      options.noise_sigma = noise;
      options.jitter_s = 1e-3;
      options.missing_part = 0.1;
      options.seed = static_cast<std::uint32_t>(draw + 1);
      const double phase = 6.0 * uniform(generator) - 3.0;
      const InversionResult result = invert_harmonics(
          synthesize_sinusoids({{low_hz, 1.0 + 5.0 * uniform(generator), 1.0, phase},
                                {high_hz, 2.0 + 9.0 * uniform(generator), 0.3, 1.0}},
                               options),
          {"y"});
      const bool fine = result.modes.size() == 2U &&
                        std::abs(result.modes[0].frequency_hz - low_hz) <
                            4.0 * result.modes[0].frequency_sigma_hz &&
                        std::abs(result.modes[1].frequency_hz - high_hz) <
                            4.0 * result.modes[1].frequency_sigma_hz;
      wrong += fine ? 0 : 1;
    }
    EXPECT_LE(wrong, 1) << noise;
  }
}

}  // namespace
}  // namespace twang
