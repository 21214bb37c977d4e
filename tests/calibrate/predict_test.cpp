// SPDX-License-Identifier: GPL-3.0-or-later
// A rig's motion foretold from another's material, against a beam with a weight at its tip.
#include "calibrate/predict.hpp"

#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "core/units.hpp"
#include "tests/support/file_rig.hpp"
#include "tests/support/rigs.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace twang {
namespace {

namespace fs = std::filesystem;

constexpr double kModulus_pa = 2e9;
constexpr double kDensity_kg_m3 = 1180.0;
constexpr double kWeight_kg = 0.005;
constexpr double kB_s = 2e-4;

/// 80 x 10 x 2 mm along x, nu 0, with a weight at the middle of its free end.
Rig weighted_strip() {
  Rig rig =
      test::make_rig({test::box_mm({0, 0, 0}, {80, 10, 2})}, {test::box_mm({0, 0, 0}, {0, 10, 2})});
  rig.materials[0].poissons_ratio = 0.0;
  rig.materials[0].density_kg_m3 = kDensity_kg_m3;
  rig.masses.push_back({Eigen::Vector3d(80, 5, 1) * kMetresPerMillimetre, kWeight_kg});
  return rig;
}

Material material() {
  Material found;
  found.material = "part";
  found.youngs_modulus_identified_pa = kModulus_pa;
  found.youngs_modulus_identified_sigma_pa = 0.002 * kModulus_pa;
  found.poissons_ratio = 0.0;
  found.density_kg_m3 = kDensity_kg_m3;
  found.damping_stiffness_b_s = kB_s;
  found.damping_stiffness_b_sigma_s = 0.005 * kB_s;
  found.frequency_hz = 65.0;
  found.decay_per_s = 0.5 * kB_s * std::pow(kTwoPi * 65.0, 2);
  found.lambda_per_s2 = std::pow(kTwoPi * found.frequency_hz, 2) + std::pow(found.decay_per_s, 2);
  found.tan_delta = kB_s * std::sqrt(found.lambda_per_s2);
  return found;
}

/// Rayleigh: a massless beam with the weight and 33/140 of its own mass at the tip.
double lambda_of_beam() {
  const double stiffness = 3.0 * kModulus_pa * 0.01 * std::pow(0.002, 3) / 12.0 / std::pow(0.08, 3);
  const double mass = kDensity_kg_m3 * 0.08 * 0.01 * 0.002;
  return stiffness / (kWeight_kg + 33.0 / 140.0 * mass);
}

/// The tip let go, with b of the strip's own frequency times `factor`.
fs::path write_trace(const test::TemporaryFolder& folder, double factor) {
  const double lambda = lambda_of_beam();
  const double d = 0.5 * factor * kB_s * lambda;
  const double w = std::sqrt(lambda - d * d);
  Trace trace;
  trace.channels.push_back({"tip_mm", {}});
  for (int n = 0; n < 480; ++n) {
    const double t = n / 240.0;
    trace.time_s.push_back(t);
    // the last digit of a tracker
    trace.channels[0].values.push_back(std::round(1e4 * std::exp(-d * t) * std::cos(w * t)) * 1e-4);
  }
  write_trace_csv(folder / "tip.csv", trace);
  return folder / "tip.csv";
}

TEST(Predict, FindsTheFrequencyAndDecayOfAWeightedBeam) {
  const test::TemporaryFolder folder;
  PredictionOptions options;
  options.max_dofs = 10000;
  const Prediction prediction =
      predict_motion(weighted_strip(), material(), write_trace(folder, 1.0), options);
  // Rayleigh's shape is the static one: an upper bound, for this weight a few parts in 10^4 off;
  // shear softens the beam by 0.1 %.
  EXPECT_LT(std::abs(prediction.frequency_error_rel), 0.003);
  EXPECT_LT(std::abs(prediction.decay_error_rel), 0.01);
  EXPECT_NEAR(prediction.damping_ratio_of_b, 1.0, 0.005);
  EXPECT_NE(prediction.sentences.back().find("One b holds"), std::string::npos)
      << prediction.sentences.back();
  EXPECT_EQ(prediction.mode.mode, 0);
  // From the tracked start the predicted motion stays with the tracked one for a few periods.
  const std::vector<double> times = {prediction.inversion.time_origin_s,
                                     prediction.inversion.time_origin_s + 0.05};
  const std::vector<double> y = motion_from_tracked_start(prediction, prediction.same_b, times);
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(
        y[i] + prediction.inversion.offsets[0], prediction.inversion.evaluate(0, times[i]), 0.02);
  }
}

TEST(Predict, OfAMeshFileIsThatOfTheSolid) {
  const test::TemporaryFolder folder;
  PredictionOptions options;
  options.max_dofs = 10000;
  const fs::path trace = write_trace(folder, 1.0);
  const test::FileRig file(weighted_strip(), 2e-3);
  const Prediction of_file = predict_motion(file.rig, material(), trace, options);
  const Prediction of_solid = predict_motion(weighted_strip(), material(), trace, options);
  EXPECT_NEAR(of_file.same_b.frequency_hz / of_solid.same_b.frequency_hz, 1.0, 0.003);
}

TEST(Predict, SaysByHowMuchBHasChangedWhereTheDecayMisses) {
  const test::TemporaryFolder folder;
  PredictionOptions options;
  options.max_dofs = 10000;
  const Prediction prediction =
      predict_motion(weighted_strip(), material(), write_trace(folder, 2.0), options);
  EXPECT_NEAR(prediction.decay_error_rel, -0.5, 0.01);
  EXPECT_NEAR(prediction.damping_ratio_of_b, 2.0, 0.01);
  const double span = std::log(std::sqrt(lambda_of_beam() / material().lambda_per_s2));
  EXPECT_NEAR(prediction.damping_exponent, std::log(2.0) / span, 0.02);
  bool said = false;
  for (const std::string& sentence : prediction.sentences) {
    said = said || sentence.find("b depends on frequency") != std::string::npos;
  }
  EXPECT_TRUE(said);
}

TEST(Predict, RefusesARigOfAnotherMaterial) {
  const test::TemporaryFolder folder;
  Material other = material();
  other.material = "rubber";
  EXPECT_THROW((void)predict_motion(weighted_strip(), other, write_trace(folder, 1.0)), InputError);
}

}  // namespace
}  // namespace twang
