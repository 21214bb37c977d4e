// SPDX-License-Identifier: GPL-3.0-or-later
// The line from traces on; films go through it in tests/app.
#include "calibrate/calibrate.hpp"

#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "tests/support/sample_strip.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

namespace twang {
namespace {

namespace fs = std::filesystem;

constexpr double kDecay_per_s = 10.0;

/// A released tip, at rest before 0.05 s.
fs::path write_trace(const test::TemporaryFolder& folder,
                     const std::string& name,
                     double frequency_hz,
                     double amplitude_mm,
                     double noise_mm = 0.0) {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  Trace trace;
  trace.channels.push_back({"observable_mm", {}});
  constexpr double kRelease_s = 0.05;
  for (int n = 0; n < 200; ++n) {
    const double t = n / 240.0;
    const double tau = std::max(0.0, t - kRelease_s);
    trace.time_s.push_back(t);
    trace.channels[0].values.push_back(-amplitude_mm * std::exp(-kDecay_per_s * tau) *
                                           std::cos(kTwoPi * frequency_hz * tau) +
                                       noise_mm * normal(generator));
  }
  write_trace_csv(folder / name, trace);
  return folder / name;
}

CalibrationOptions quick() {
  CalibrationOptions options;
  options.ladder.max_dofs = 30000;
  return options;
}

TEST(Calibrate, FindsTheModulusOfAPlateStripInAKnownTrace) {
  const test::TemporaryFolder folder;
  const Calibration calibration = calibrate_from_traces(
      test::sample_strip(), {write_trace(folder, "a.csv", 64.0, 1.0)}, quick());
  const double lambda = std::pow(kTwoPi * 64.0, 2) + kDecay_per_s * kDecay_per_s;
  EXPECT_NEAR(calibration.material.lambda_per_s2 / lambda, 1.0, 1e-5);
  EXPECT_NEAR(
      calibration.material.damping_stiffness_b_s / (2.0 * kDecay_per_s / lambda), 1.0, 1e-3);
  // Euler's cantilever, 1.8751² sqrt(E h² / 12 rho) / L² = omega; width and nu = 0.45 stiffen it by
  // some per cent
  const double beam =
      std::pow(0.08, 4) * 12.0 * 1180.0 * lambda / (std::pow(1.875104, 4) * 0.002 * 0.002);
  EXPECT_NEAR(calibration.material.youngs_modulus_identified_pa / beam, 0.97, 0.04);
  EXPECT_LT(calibration.material.youngs_modulus_numerical_pa,
            calibration.material.youngs_modulus_identified_pa);
  ASSERT_TRUE(calibration.validation.has_value());
  EXPECT_LT(calibration.material.validation.rms_rel, 0.03);
  EXPECT_LT(std::abs(calibration.material.validation.frequency_error_rel), 0.005);
  EXPECT_LT(std::abs(calibration.material.validation.decay_error_rel), 0.05);
}

TEST(Calibrate, PutsTheScatterOfRepeatsIntoTheBudget) {
  const test::TemporaryFolder folder;
  CalibrationOptions options = quick();
  options.validate = false;
  const Calibration calibration =
      calibrate_from_traces(test::sample_strip(),
                            // without noise two modes explain both exactly, and rightly so
                            {write_trace(folder, "a.csv", 64.0, 1.0, 0.01),
                             write_trace(folder, "b.csv", 64.64, 1.0, 0.01)},
                            options);
  // two values one per cent apart in f, two in lambda: half their distance is the standard error
  EXPECT_NEAR(calibration.material.uncertainty.repeats, 0.01, 0.0005);
  EXPECT_GT(calibration.material.frequency_hz, 64.0);
  EXPECT_LT(calibration.material.frequency_hz, 64.64);
  EXPECT_EQ(calibration.material.provenance.inputs.size(), 3U);
}

TEST(Calibrate, SaysThatASmallMotionNeedsNoRefinement) {
  const test::TemporaryFolder folder;
  CalibrationOptions options = quick();
  options.validate = false;
  options.refine = true;
  const std::vector<fs::path> trace = {write_trace(folder, "a.csv", 64.0, 0.1, 5e-4)};
  const Calibration calibration = calibrate_from_traces(test::sample_strip(), trace, options);
  ASSERT_TRUE(calibration.refined.has_value());
  EXPECT_TRUE(calibration.refined->agrees) << calibration.refined->message;
  EXPECT_FALSE(calibration.material.refinement.has_value());
  EXPECT_EQ(calibration.remarks.back(), calibration.refined->message);
  // the linear estimate's, to the digit
  EXPECT_EQ(calibration.material.damping_stiffness_b_s, calibration.target.damping_stiffness_b_s);

  Rig nowhere = test::sample_strip();
  nowhere.observable.reset();
  EXPECT_THROW((void)calibrate_from_traces(nowhere, trace, options), InputError);
}

TEST(Calibrate, RefusesARigWhoseModulusIsStated) {
  const test::TemporaryFolder folder;
  Rig rig = test::sample_strip();
  rig.materials[0].youngs_modulus_pa = 2e9;
  EXPECT_THROW((void)calibrate_from_traces(rig, {write_trace(folder, "a.csv", 64.0, 1.0)}, quick()),
               InputError);
}

TEST(Calibrate, SaysThatATraceOfRestHoldsNoVibration) {
  const test::TemporaryFolder folder;
  EXPECT_THROW((void)calibrate_from_traces(
                   test::sample_strip(), {write_trace(folder, "rest.csv", 64.0, 0.0)}, quick()),
               NumericalFailure);
}

}  // namespace
}  // namespace twang
