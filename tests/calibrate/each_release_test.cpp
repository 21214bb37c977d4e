// SPDX-License-Identifier: GPL-3.0-or-later
// Several plucks of a strip in one trace, as repeats.
#include "calibrate/calibrate.hpp"
#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "tests/support/sample_strip.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

namespace twang {
namespace {

constexpr double kRate_hz = 480.0;
constexpr double kFrequency_hz = 64.0;
constexpr double kDecay_per_s = 10.0;
constexpr double kNoise_mm = 0.01;

/// One pluck: rest, a slow pull, a hold, and free motion until it is still [s].
constexpr double kRest_s = 0.15;
constexpr double kPull_s = 0.5;
constexpr double kHold_s = 0.2;
constexpr double kFree_s = 0.9;
constexpr double kPluck_s = kRest_s + kPull_s + kHold_s + kFree_s;

/// The tip while it is plucked once at each of these frequencies.
Trace plucked(const std::vector<double>& frequencies_hz, double noise_mm = kNoise_mm) {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  Trace trace;
  trace.channels.push_back({"observable_mm", {}});
  const double end_s = kPluck_s * static_cast<double>(frequencies_hz.size());
  for (int i = 0; i / kRate_hz < end_s; ++i) {
    const double t = i / kRate_hz;
    const auto n = static_cast<std::size_t>(t / kPluck_s);
    const double pulled_mm = n % 2 == 0 ? 1.0 : 1.3;
    const double s = t - static_cast<double>(n) * kPluck_s - kRest_s;
    double y = 0.5 * pulled_mm * (1.0 - std::cos(kPi * std::clamp(s / kPull_s, 0.0, 1.0)));
    const double u = s - kPull_s - kHold_s;
    if (u > 0.0) y *= std::exp(-kDecay_per_s * u) * std::cos(kTwoPi * frequencies_hz[n] * u);
    trace.time_s.push_back(t);
    trace.channels[0].values.push_back(y + noise_mm * normal(generator));
  }
  return trace;
}

Calibration calibrate(const Trace& trace, CalibrationOptions options = {}) {
  const test::TemporaryFolder folder;
  write_trace_csv(folder / "plucks.csv", trace);
  options.ladder.max_dofs = 30000;
  options.validate = false;
  return calibrate_from_traces(test::sample_strip(), {folder / "plucks.csv"}, options);
}

CalibrationOptions each_release() {
  CalibrationOptions options;
  options.each_release = true;
  return options;
}

/// (2 pi f)² + d²
double lambda_of(double frequency_hz) {
  return std::pow(kTwoPi * frequency_hz, 2) + kDecay_per_s * kDecay_per_s;
}

TEST(EachRelease, OfOneTraceGivesModulusAndDampingAsARepeat) {
  const std::vector<double> plucks(4, kFrequency_hz);
  const Calibration calibration = calibrate(plucked(plucks), each_release());
  ASSERT_EQ(calibration.repeats.size(), plucks.size());
  const Material& found = calibration.material;
  // One pluck without noise: the modulus goes with lambda.
  const Material truth = calibrate(plucked({kFrequency_hz}, 0.0)).material;
  EXPECT_NEAR(truth.lambda_per_s2 / lambda_of(kFrequency_hz), 1.0, 1e-5);
  // The mesh, the clock and the like are the same for both: what the fit and its repeats leave.
  const double relative_sigma =
      std::hypot(found.uncertainty.statistical, found.uncertainty.repeats);
  EXPECT_LT(relative_sigma, 1e-3);
  EXPECT_NEAR(found.youngs_modulus_identified_pa / truth.youngs_modulus_identified_pa,
              1.0,
              3.0 * relative_sigma);
  EXPECT_NEAR(found.damping_stiffness_b_s,
              2.0 * kDecay_per_s / lambda_of(kFrequency_hz),
              3.0 * found.damping_stiffness_b_sigma_s);
  EXPECT_LT(found.damping_stiffness_b_sigma_s, 0.02 * found.damping_stiffness_b_s);
}

TEST(EachRelease, PutsTheScatterBetweenReleasesIntoTheBudget) {
  const std::vector<double> plucks = {63.7, 64.3, 64.0};
  const Calibration calibration = calibrate(plucked(plucks), each_release());
  ASSERT_EQ(calibration.repeats.size(), 3U);
  double mean = 0.0;
  for (const double f : plucks) mean += lambda_of(f) / 3.0;
  double variance = 0.0;
  for (const double f : plucks) variance += std::pow(lambda_of(f) - mean, 2) / 2.0;
  // 5.4e-3; noise alone would leave a tenth of that.
  const double expected = std::sqrt(variance / 3.0) / mean;
  EXPECT_NEAR(calibration.material.uncertainty.repeats, expected, 0.1 * expected);
  // All share their poles: within what they differ by.
  EXPECT_NEAR(calibration.material.lambda_per_s2 / mean, 1.0, 2.0 * expected);
  // The rig and one trace were read.
  EXPECT_EQ(calibration.material.provenance.inputs.size(), 2U);
  EXPECT_EQ(calibration.material.provenance.options.at("each_release"), "true");
}

TEST(EachRelease, HasItsOwnWindowAndDecayChecks) {
  const Calibration calibration =
      calibrate(plucked(std::vector<double>(3, kFrequency_hz)), each_release());
  const RepeatedInversion repeated = inversion_of_repeats(calibration);
  ASSERT_EQ(repeated.alone.size(), 3U);
  for (std::size_t n = 0; n < 3; ++n) {
    const double release_s = static_cast<double>(n) * kPluck_s + kRest_s + kPull_s + kHold_s;
    ASSERT_TRUE(repeated.alone[n].release_s);
    EXPECT_NEAR(*repeated.alone[n].release_s, release_s, 2.0 / kRate_hz);
    ASSERT_EQ(repeated.alone[n].decay_checks.size(), 2U);
    const DampedSinusoid* mode = repeated.mode_alone(n);
    ASSERT_NE(mode, nullptr);
    for (const DecayCheck& check : repeated.alone[n].decay_checks) {
      ASSERT_TRUE(check.usable()) << check.method << ": " << check.message;
      // A check of few points; five per cent is far from what another release or a hold would give.
      EXPECT_NEAR(check.decay_per_s, mode->decay_per_s, 0.05 * kDecay_per_s);
    }
  }
  EXPECT_TRUE(std::isfinite(repeated.frequency_scatter_hz));
}

TEST(EachRelease, IsNotTakenUnlessAskedFor) {
  const Calibration calibration = calibrate(plucked(std::vector<double>(3, kFrequency_hz)));
  EXPECT_EQ(calibration.repeats.size(), 1U);
  EXPECT_EQ(calibration.material.uncertainty.repeats, 0.0);
  EXPECT_EQ(calibration.material.provenance.options.count("each_release"), 0U);
}

TEST(EachRelease, KeepsToTheStartAndEndGiven) {
  CalibrationOptions options = each_release();
  options.inversion.start_s = kPluck_s;  // past the first of four
  options.inversion.end_s = 3.0 * kPluck_s;
  const Calibration calibration =
      calibrate(plucked({50.0, kFrequency_hz, kFrequency_hz, 80.0}), options);
  ASSERT_EQ(calibration.repeats.size(), 2U);
  EXPECT_NEAR(calibration.material.frequency_hz, kFrequency_hz, 0.1);
}

}  // namespace
}  // namespace twang
