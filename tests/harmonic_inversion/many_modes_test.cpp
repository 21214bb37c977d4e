// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "harmonic_inversion/cramer_rao.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace twang {
namespace {

/// omega [rad/s] and gamma [1/s] of arXiv 1606.00391: unit amplitudes, 128 samples over 1 s.
const std::vector<std::pair<double, double>> kFifteen = {{32.85, 4.61},
                                                         {36.51, 9.44},
                                                         {38.29, 12.95},
                                                         {48.82, 0.09},
                                                         {105.63, 9.24},
                                                         {146.96, 14.88},
                                                         {183.24, 10.19},
                                                         {191.10, 7.46},
                                                         {217.34, 11.21},
                                                         {241.39, 2.18},
                                                         {253.59, 11.03},
                                                         {283.60, 9.64},
                                                         {298.20, 4.42},
                                                         {299.85, 12.25},
                                                         {304.95, 9.20}};

TEST(ManyModes, AreAllFoundToTwoDecimalsInFewSamples) {
  std::vector<SinusoidTruth> truth;
  for (const auto& [omega, gamma] : kFifteen)
    truth.push_back({omega / kTwoPi, gamma, 1.0, 0.5 * kPi});
  SynthesisOptions options;
  options.rate_hz = 128.0;
  options.duration_s = 127.0 / 128.0;
  const InversionResult result = invert_harmonics(synthesize_sinusoids(truth, options), {"y"});
  ASSERT_EQ(result.modes.size(), kFifteen.size()) << result.message;
  std::vector<std::pair<double, double>> found;
  for (const DampedSinusoid& mode : result.modes) {
    found.emplace_back(kTwoPi * mode.frequency_hz, mode.decay_per_s);
  }
  std::sort(found.begin(), found.end());
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_NEAR(found[k].first, kFifteen[k].first, 0.005);  // two decimals
    EXPECT_NEAR(found[k].second, kFifteen[k].second, 0.005);
  }
}

TEST(ManyModes, AreFoundInALongRecordWithHonestSigmas) {
  std::vector<SinusoidTruth> truth;
  for (int k = 0; k < 10; ++k)
    truth.push_back({40.0 + 15.5 * k, 0.5 + 0.1 * k, 0.3 + 0.07 * k, 0.5 * k});
  SynthesisOptions options;
  options.rate_hz = 1000.0;
  options.duration_s = 6.0;
  options.noise_sigma = 0.03;
  const InversionResult result = invert_harmonics(synthesize_sinusoids(truth, options), {"y"});
  ASSERT_EQ(result.modes.size(), truth.size()) << result.message;
  const std::vector<CramerRaoBound> bounds = cramer_rao_bounds(truth, options);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const auto mode = std::min_element(
        result.modes.begin(), result.modes.end(), [&](const auto& a, const auto& b) {
          return std::abs(a.frequency_hz - truth[k].frequency_hz) <
                 std::abs(b.frequency_hz - truth[k].frequency_hz);
        });
    // Four sigma of 20 values: one of 800 seeds, and the seed is fixed.
    EXPECT_NEAR(mode->frequency_hz, truth[k].frequency_hz, 4.0 * bounds[k].frequency_hz);
    EXPECT_NEAR(mode->decay_per_s, truth[k].decay_per_s, 4.0 * bounds[k].decay_per_s);
    // The residual's scatter of 6001 samples is 1 %, that of d in d's sigma some more.
    EXPECT_NEAR(mode->frequency_sigma_hz, bounds[k].frequency_hz, 0.1 * bounds[k].frequency_hz);
  }
}

}  // namespace
}  // namespace twang
