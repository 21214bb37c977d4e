// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/validate_material.hpp"

#include "coarsen/mesh_ladder.hpp"
#include "core/constants.hpp"
#include "rigs/load_rig.hpp"
#include "tests/simulate/sample_scene.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/file_rig.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace twang {
namespace {

using test::holds;
using test::refusal_of;

constexpr double kDamping_s = 4e-5;
constexpr double kModulus = 1.5e9;

Rig strip_with_observable() {
  std::string text = test::kStripRig;
  text.append("[observable]\nkind = \"displacement\"\nmarker = \"tip\"\n");
  text.append("direction = [0.0, 0.0, 1.0]\n[camera]\ncapture_fps = 2000\n");
  return parse_rig(text, "strip.toml");
}

/// A mesh of 8 x 2 x 1 cells of 5 mm and its E_n.
Material material_of_mesh() {
  Material material;
  material.youngs_modulus_numerical_pa = kModulus;
  material.youngs_modulus_identified_pa = kModulus / 2.0;
  material.numerical_element = "hex8";
  material.numerical_dx_mm = 5.0;
  material.numerical_elements = 16;
  material.damping_stiffness_b_s = kDamping_s;
  material.poissons_ratio = 0.4;
  material.density_kg_m3 = 1180.0;
  return material;
}

/// What the mesh's first mode does by eq. (14), of small amplitude, and `factor` times as fast.
Trace small_vibration(const Rig& rig, double factor) {
  const double lambda = compute_rung(rig, 5e-3, ElementKind::Hex8, 1).modes.lambda_per_s2[0] *
                        kModulus * factor * factor;
  const double d = 0.5 * kDamping_s * lambda;
  const double omega = std::sqrt(lambda - d * d);
  Trace trace;
  trace.channels.push_back({"observable_mm", {}});
  for (int i = 0; i < 400; ++i) {
    const double t = 5e-4 * i;
    trace.time_s.push_back(t);
    trace.channels[0].values.push_back(0.05 * std::exp(-d * t) * std::cos(omega * t));
  }
  return trace;
}

TEST(ValidateMaterial, AMeshFollowsItsOwnSmallVibration) {
  const Rig rig = strip_with_observable();
  const MaterialValidation result =
      validate_material(rig, material_of_mesh(), small_vibration(rig, 1.0));
  // The trapezoidal rule's period is longer by (omega h)²/12 = 3.3e-4, ten periods drift by 2 %
  // of a radian; the amplitude is 1/800 of the length.
  EXPECT_LT(result.validation.figures.rms_rel, 0.02);
  EXPECT_NEAR(result.validation.figures.frequency_error_rel, -3.3e-4, 2e-4);
  EXPECT_NEAR(result.validation.figures.decay_error_rel, 0.0, 0.01);
  EXPECT_NEAR(result.phase_drift_rad, -9.0 * kTwoPi * 3.3e-4, 0.01);
  for (const FigureOfMerit& figure : result.figures()) EXPECT_TRUE(figure.met()) << figure.name;
  EXPECT_TRUE(holds(validation_to_json(result), "\"all_met\": true"));
}

TEST(ValidateMaterial, AMeshFileIsCutIntoTheCellsToWhichTheModulusBelongs) {
  const Rig rig = strip_with_observable();
  const Trace trace = small_vibration(rig, 1.0);
  const test::FileRig file(rig, 2.5e-3);
  const MaterialValidation of_file = validate_material(file.rig, material_of_mesh(), trace);
  const MaterialValidation of_solid = validate_material(rig, material_of_mesh(), trace);
  EXPECT_EQ(of_file.num_elements, of_solid.num_elements);
  EXPECT_NEAR(of_file.validation.simulated_sinusoid.frequency_hz,
              of_solid.validation.simulated_sinusoid.frequency_hz,
              1e-6 * of_solid.validation.simulated_sinusoid.frequency_hz);
}

TEST(ValidateMaterial, AWrongModulusIsSeenInFrequencyAndPhase) {
  const Rig rig = strip_with_observable();
  const MaterialValidation result =
      validate_material(rig, material_of_mesh(), small_vibration(rig, 1.02));
  EXPECT_NEAR(result.validation.figures.frequency_error_rel, 1.0 / 1.02 - 1.0, 1e-3);
  // 2 % late between the middles of the first and the tenth period, which lie nearer to the first
  // period's beginning and the last one's, for both decay
  EXPECT_NEAR(result.phase_drift_rad, -9.0 * kTwoPi * 0.02, 0.2);
  EXPECT_FALSE(result.figures()[1].met());
  EXPECT_TRUE(holds(validation_to_json(result), "\"all_met\": false"));
}

TEST(ValidateMaterial, RefusesAnotherMeshAndWhatIsNotThere) {
  const Rig rig = strip_with_observable();
  const Trace trace = small_vibration(rig, 1.0);
  const auto refusal = [&](const Material& material, const MaterialValidationOptions& options) {
    return refusal_of([&] { static_cast<void>(validate_material(rig, material, trace, options)); });
  };
  MaterialValidationOptions finer;
  finer.dx_m = 4e-3;
  EXPECT_TRUE(holds(refusal(material_of_mesh(), finer), "belongs to a mesh of 16 hex8"));
  MaterialValidationOptions column;
  column.column = "tip.q_mm";
  EXPECT_TRUE(holds(refusal(material_of_mesh(), column), "no column \"tip.q_mm\""));
  Trace angles = trace;
  angles.channels[0].name = "observable_rad";
  EXPECT_TRUE(holds(
      refusal_of([&] { static_cast<void>(validate_material(rig, material_of_mesh(), angles)); }),
      "observable_rad is not the rig's observable, must be observable_mm"));
  Material none = material_of_mesh();
  none.youngs_modulus_numerical_pa = kNaN;
  EXPECT_TRUE(holds(refusal(none, {}), "lacks its numerical modulus"));
}

TEST(PhaseDrift, IsTheLeadGainedBetweenFirstAndLastPeriod) {
  std::vector<double> time;
  std::vector<double> a;
  std::vector<double> b;
  for (int i = 0; i < 1000; ++i) {
    time.push_back(1e-3 * i);
    a.push_back(std::cos(kTwoPi * 10.0 * time.back()) + 3.0);
    b.push_back(2.0 * std::cos(kTwoPi * 10.02 * time.back() + 0.4));
  }
  // 0.02 Hz over the 0.9 s between the middles of both; that the fit is at 10 Hz shifts both alike.
  EXPECT_NEAR(phase_drift(time, a, b, 10.0), kTwoPi * 0.02 * 0.9, 1e-3);
  EXPECT_NEAR(phase_drift(time, b, a, 10.0), -kTwoPi * 0.02 * 0.9, 1e-3);
  EXPECT_TRUE(std::isnan(phase_drift({0.0, 0.01}, {1.0, 2.0}, {1.0, 2.0}, 10.0)));
}

}  // namespace
}  // namespace twang
