// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/decay_checks.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "harmonic_inversion/ridge_line.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace twang {
namespace {

constexpr double kFrequencyHz = 20.0;

/// d of a damping ratio: zeta = d / sqrt((2 pi f)² + d²).
double decay_of(double damping_ratio) {
  return damping_ratio / std::sqrt(1.0 - damping_ratio * damping_ratio) * kTwoPi * kFrequencyHz;
}

/// What a perfect fit would answer: the truth, so that the checks alone are tested.
InversionResult truth_of(const std::vector<SinusoidTruth>& sinusoids, const Trace& trace) {
  InversionResult result;
  for (const SinusoidTruth& truth : sinusoids) {
    DampedSinusoid mode;
    mode.frequency_hz = truth.frequency_hz;
    mode.decay_per_s = truth.decay_per_s;
    mode.decay_sigma_per_s = 0.0;
    mode.channels.push_back({"y", truth.amplitude, truth.phase_rad});
    result.modes.push_back(mode);
  }
  result.time_origin_s = trace.time_s.front();
  result.time_end_s = trace.time_s.back();
  result.channel_names = {"y"};
  result.offsets = {0.0};
  result.drifts_per_s = {0.0};
  return result;
}

/// Of a pure decay: the decrement first, the wavelet second.
std::vector<DecayCheck> check_pure(double damping_ratio,
                                   double snr_db,
                                   std::uint32_t seed,
                                   SynthesisOptions options = {}) {
  options.noise_sigma = std::pow(10.0, -snr_db / 20.0);
  options.seed = seed;
  const std::vector<SinusoidTruth> truth = {
      {kFrequencyHz, decay_of(damping_ratio), 1.0, 0.1 * seed}};
  const Trace trace = synthesize_sinusoids(truth, options);
  return check_decay(trace, "y", truth_of(truth, trace), 0);
}

class PureDecay : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(PureDecay, IsAgreedUponWithinTheStatedSigmas) {
  const auto [damping_ratio, snr_db] = GetParam();
  constexpr int kSeeds = 40;
  for (std::size_t method = 0; method < 2; ++method) {
    int usable = 0;
    int within_one = 0;
    int within_two = 0;
    int frequency_within_two = 0;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
      const DecayCheck check = check_pure(damping_ratio, snr_db, seed)[method];
      if (!check.usable()) continue;
      ++usable;
      const double off = std::abs(check.decay_per_s - decay_of(damping_ratio));
      within_one += off < check.decay_sigma_per_s ? 1 : 0;
      within_two += off < 2.0 * check.decay_sigma_per_s ? 1 : 0;
      frequency_within_two +=
          std::abs(check.frequency_hz - kFrequencyHz) < 2.0 * check.frequency_sigma_hz ? 1 : 0;
      // Of 960 draws in all some three lie beyond 3 sigmas; beyond 4 lies one in 16,000.
      EXPECT_LT(off, 4.0 * check.decay_sigma_per_s) << check.method << ", seed " << seed;
    }
    EXPECT_EQ(usable, kSeeds);
    // Binomial of 40: 68 % within one sigma has a standard deviation of 3, so 17 is 3.4 of them
    // below; the sigma widened by the scatter of few points may cover all.
    EXPECT_GE(within_one, 17);
    // 95 % within two: a standard deviation of 1.4, so 33 is 3.6 of them below.
    EXPECT_GE(within_two, 33);
    EXPECT_GE(frequency_within_two, 33);
    // Sigmas that are far too wide cover everything: at most 38 of 40 within one, where the
    // widening of few points brings it to 34.
    EXPECT_LE(within_one, 38);
  }
}

INSTANTIATE_TEST_SUITE_P(DampingAndNoise,
                         PureDecay,
                         testing::Values(std::tuple(0.005, 20.0),
                                         std::tuple(0.005, 40.0),
                                         std::tuple(0.02, 20.0),
                                         std::tuple(0.02, 30.0),
                                         std::tuple(0.05, 30.0),
                                         std::tuple(0.05, 60.0),
                                         std::tuple(0.1, 30.0),
                                         std::tuple(0.1, 40.0),
                                         std::tuple(0.1, 60.0),
                                         std::tuple(0.2, 40.0),
                                         std::tuple(0.2, 50.0),
                                         std::tuple(0.2, 60.0)));

TEST(DecayCheck, IsExactWithoutNoise) {
  for (const double damping_ratio : {0.005, 0.02, 0.05, 0.1, 0.2}) {
    const std::vector<DecayCheck> checks = check_pure(damping_ratio, 300.0, 3);
    ASSERT_EQ(checks.size(), 2U);
    for (const DecayCheck& check : checks) {
      ASSERT_TRUE(check.usable()) << check.method << ": " << check.message;
      // The wavelet is cut off 3.5 tau before the record begins, where it is 0.02 % in sum, and its
      // slope spans a few tau; the decrement's points are those of an exponential.
      const double bound = check.method == "Morlet wavelet" ? 2e-3 : 1e-6;
      EXPECT_NEAR(check.decay_per_s, decay_of(damping_ratio), bound * decay_of(damping_ratio))
          << check.method;
      EXPECT_NEAR(check.frequency_hz, kFrequencyHz, 1e-4 * kFrequencyHz) << check.method;
    }
  }
}

TEST(DecayCheck, BearsUnevenAndMissingSamples) {
  SynthesisOptions options;
  options.jitter_s = 0.001;  // a quarter of a sample
  options.missing_part = 0.2;
  int within_two = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    for (const DecayCheck& check : check_pure(0.02, 40.0, seed, options)) {
      ASSERT_TRUE(check.usable()) << check.method << ": " << check.message;
      within_two +=
          std::abs(check.decay_per_s - decay_of(0.02)) < 2.0 * check.decay_sigma_per_s ? 1 : 0;
    }
  }
  // Binomial of 40 at 95 %: as above.
  EXPECT_GE(within_two, 33);
}

TEST(DecayCheck, TakesMeansWherePeriodsAreDenselySampled) {
  SynthesisOptions options;
  options.rate_hz = 20000.0;  // a thousand a period
  int within_two = 0;
  double worst_sigma = 0.0;
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    for (const DecayCheck& check : check_pure(0.02, 20.0, seed, options)) {
      ASSERT_TRUE(check.usable()) << check.method << ": " << check.message;
      within_two +=
          std::abs(check.decay_per_s - decay_of(0.02)) < 2.0 * check.decay_sigma_per_s ? 1 : 0;
      worst_sigma = std::max(worst_sigma, check.decay_sigma_per_s);
    }
  }
  // Binomial of 20 at 95 %: a standard deviation of 1, so 16 is 3 of them below.
  EXPECT_GE(within_two, 16);
  // At 240 samples a second the sigmas are 7 and 11 % of d; the noise of the means is sqrt(83)
  // times less. The decrement, of 15 extrema there, may use more of them here.
  EXPECT_LT(worst_sigma, 0.015 * decay_of(0.02));
}

TEST(DecayCheck, OfAHundredThousandExtremaNeedsNoMatrixOfThem) {
  // Of 100,000 squared numbers, 80 GB.
  SynthesisOptions options;
  options.rate_hz = 120.0;
  options.duration_s = 2500.0;
  options.noise_sigma = 0.01;
  const std::vector<SinusoidTruth> truth = {{kFrequencyHz, 1e-3, 1.0, 0.3}};
  const Trace trace = synthesize_sinusoids(truth, options);
  const DecayCheck decrement = check_decay(trace, "y", truth_of(truth, trace), 0).front();
  ASSERT_TRUE(decrement.usable()) << decrement.message;
  EXPECT_NEAR(decrement.num_points, 100000, 10);
  // Beyond 4 sigmas lies one draw in 16,000.
  EXPECT_NEAR(decrement.decay_per_s, 1e-3, 4.0 * decrement.decay_sigma_per_s);
}

TEST(RidgeLine, ThroughIndependentPointsIsThatOfADiagonalCovariance) {
  Eigen::VectorXd x(5);
  Eigen::VectorXd y(5);
  Eigen::VectorXd variance(5);
  x << 0.0, 1.0, 2.5, 3.0, 7.0;
  y << 1.0, 0.2, 0.4, -1.0, -2.0;
  variance << 0.1, 0.02, 0.3, 0.05, 0.2;
  const RidgeLine dense = fit_ridge_line(x, y, variance.asDiagonal());
  const RidgeLine line = fit_ridge_line_through_independent(x, y, variance);
  // Round-off.
  EXPECT_NEAR(line.mean_x, dense.mean_x, 1e-14);
  EXPECT_NEAR(line.mean, dense.mean, 1e-14);
  EXPECT_NEAR(line.slope, dense.slope, 1e-14);
  EXPECT_NEAR(line.slope_sigma, dense.slope_sigma, 1e-14);
}

TEST(MorletCheck, IsNotMisledByAModeNearby) {
  // At 26 Hz, as strong and as long: under the shortest wavelet, 3 / omega wide, it would leak in
  // by exp(-(3 * 0.3)² / 2) = 2/3 of the mode.
  const std::vector<SinusoidTruth> truth = {{kFrequencyHz, 3.0, 1.0, 0.4}, {26.0, 3.0, 1.0, 2.0}};
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    SynthesisOptions options;
    options.noise_sigma = 0.01;
    options.seed = seed;
    const Trace trace = synthesize_sinusoids(truth, options);
    const DecayCheck check = check_decay(trace, "y", truth_of(truth, trace), 0)[1];
    ASSERT_TRUE(check.usable()) << check.message;
    // 4 sigmas as above, and the leak allowed: a thousandth of |W| at both ends of a ridge that is
    // at least 1.5 tau long.
    EXPECT_NEAR(check.decay_per_s, 3.0, 4.0 * check.decay_sigma_per_s);
    // A wavelet that tells the two apart uses the record less well than the fit, whose sigma is
    // sqrt(8 d³ noise² dt) = 0.01 at the Cramer-Rao bound; measured 0.045.
    EXPECT_LT(check.decay_sigma_per_s, 0.1);
  }
}

TEST(MorletCheck, SaysThatAModeIsTooNearForTheRecord) {
  const std::vector<SinusoidTruth> truth = {{kFrequencyHz, 3.0, 1.0, 0.4}, {20.5, 3.0, 0.8, 2.0}};
  SynthesisOptions options;
  options.noise_sigma = 0.01;
  const Trace trace = synthesize_sinusoids(truth, options);
  const DecayCheck check = check_decay(trace, "y", truth_of(truth, trace), 0)[1];
  EXPECT_FALSE(check.usable());
  EXPECT_TRUE(std::isnan(check.decay_per_s));
  EXPECT_NE(check.message.find("other modes"), std::string::npos) << check.message;
}

TEST(DecayCheck, SaysThatARecordIsTooShort) {
  SynthesisOptions options;
  options.duration_s = 0.075;  // one and a half periods: three extrema
  for (const DecayCheck& check : check_pure(0.02, 40.0, 1, options)) {
    EXPECT_FALSE(check.usable()) << check.method;
    EXPECT_TRUE(std::isnan(check.decay_per_s));
    EXPECT_TRUE(std::isnan(check.frequency_hz));
    EXPECT_FALSE(check.message.empty());
  }
}

TEST(DecayCheck, SpeaksUpWhereTheFitIsWrongAndOnlyThere) {
  const std::vector<SinusoidTruth> truth = {{kFrequencyHz, 3.0, 1.0, 0.4}};
  SynthesisOptions options;
  options.noise_sigma = 0.001;
  const Trace trace = synthesize_sinusoids(truth, options);
  EXPECT_TRUE(with_decay_checks(truth_of(truth, trace), trace).notes.empty());
  const std::vector<DecayCheck> checks = check_decay(trace, truth_of(truth, trace));
  ASSERT_EQ(checks.size(), 2U);
  for (const DecayCheck& check : checks) {
    DampedSinusoid mode = truth_of(truth, trace).modes.front();
    mode.decay_per_s = 3.2;  // 7 %, and the sigmas are below 1 %
    const std::string sentence = disagreement(check, mode);
    EXPECT_NE(sentence.find(check.method), std::string::npos) << sentence;
    mode.decay_sigma_per_s = 0.1;  // two joint sigmas
    EXPECT_TRUE(disagreement(check, mode).empty());
    mode.decay_sigma_per_s = 0.0;
    mode.decay_per_s = 3.05;  // under 2 %, whatever the sigmas
    EXPECT_TRUE(disagreement(check, mode).empty());
  }
}

TEST(DecayCheck, TakesTheChannelThatShowsTheModeBest) {
  const std::vector<SinusoidTruth> truth = {{kFrequencyHz, 3.0, 1.0, 0.4}};
  SynthesisOptions options;
  options.noise_sigma = 0.001;
  Trace trace = synthesize_sinusoids(truth, options);
  Channel small = trace.channels.front();
  small.name = "small";
  for (double& value : small.values) value *= 0.1;
  trace.channels.insert(trace.channels.begin(), small);
  const InversionResult result = invert_harmonics(trace, {"small", "y"});
  ASSERT_TRUE(result.usable());
  // Scaled alike in signal and noise both show it equally well; with the noise of the other on top
  // the small one does not.
  InversionResult noisy = result;
  noisy.modes.front().channels[0].amplitude_sigma *= 10.0;
  for (const DecayCheck& check : check_decay(trace, noisy)) EXPECT_EQ(check.channel, "y");
}

TEST(DecayCheck, RefusesWhatIsNotThere) {
  const std::vector<SinusoidTruth> truth = {{kFrequencyHz, 3.0, 1.0, 0.4}};
  const Trace trace = synthesize_sinusoids(truth);
  EXPECT_THROW((void)check_decay(trace, "z", truth_of(truth, trace), 0), InputError);
  EXPECT_THROW((void)check_decay(trace, "y", truth_of(truth, trace), 1), InputError);
  EXPECT_TRUE(check_decay(
                  trace,
                  "y",
                  [&] {
                    InversionResult none = truth_of(truth, trace);
                    none.modes.clear();
                    return none;
                  }(),
                  0)
                  .empty());
}

}  // namespace
}  // namespace twang
