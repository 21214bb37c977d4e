// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/rheology.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace twang {
namespace {

/// A calibration of a material with E = E0 f^n and a loss factor, at one frequency.
NamedMaterial calibration(double f, double exponent, double tan_delta, double sigma_rel) {
  NamedMaterial named;
  named.name = std::to_string(f);
  Material& material = named.material;
  material.material = "silicone";
  material.density_kg_m3 = 1070.0;
  material.poissons_ratio = 0.49;
  const double lambda = std::pow(kTwoPi * f, 2) / (1.0 - 0.25 * tan_delta * tan_delta);
  material.frequency_hz = f;
  material.lambda_per_s2 = lambda;
  material.decay_per_s = 0.5 * tan_delta * std::sqrt(lambda);
  material.frequency_sigma_hz = 1e-4 * f;
  material.decay_sigma_per_s = 0.01 * material.decay_per_s;
  material.tan_delta = tan_delta;
  material.damping_stiffness_b_s = tan_delta / std::sqrt(lambda);
  material.damping_stiffness_b_sigma_s = 0.01 * material.damping_stiffness_b_s;
  material.youngs_modulus_identified_pa = 3e5 * std::pow(f, exponent);
  material.uncertainty.statistical = sigma_rel;
  material.uncertainty.density = 0.05;  // common to all: takes no part
  material.youngs_modulus_identified_sigma_pa =
      material.youngs_modulus_identified_pa * material.uncertainty.total();
  return named;
}

TEST(Rheology, FindsAPowerLawAndItsLossFactor) {
  constexpr double kExponent = 0.06;
  const double tan_delta = std::tan(0.5 * kPi * kExponent);
  const FrequencyDependence found =
      frequency_dependence({calibration(40, kExponent, tan_delta, 0.002),
                            calibration(4, kExponent, tan_delta, 0.002),
                            calibration(12, kExponent, tan_delta, 0.002)});
  ASSERT_EQ(found.points.size(), 3U);
  EXPECT_EQ(found.points.front().frequency_hz, 4.0) << "ascending";
  ASSERT_TRUE(found.modulus && found.tan_delta && found.damping);
  EXPECT_NEAR(found.modulus->exponent, kExponent, 1e-12);  // exact points
  EXPECT_NEAR(found.modulus->at(4.0) / (3e5 * std::pow(4.0, kExponent)), 1.0, 1e-12);
  EXPECT_NEAR(found.tan_delta->exponent, 0.0, 1e-12);
  EXPECT_NEAR(found.damping->exponent, -1.0, 1e-12);
  EXPECT_NEAR(found.tan_delta_of_exponent, tan_delta, 1e-12);
  EXPECT_TRUE(found.changes);
  EXPECT_NE(found.sentences[0].find("changes with frequency"), std::string::npos);
  EXPECT_NE(found.sentences[1].find("the two agree"), std::string::npos) << found.sentences[1];
  // The slope's sigma by hand: sigma over the spread of ln f.
  double spread = 0.0;
  const double mean = std::log(4.0 * 12.0 * 40.0) / 3.0;
  for (const double f : {4.0, 12.0, 40.0}) spread += std::pow(std::log(f) - mean, 2);
  EXPECT_NEAR(found.modulus->exponent_sigma, 0.002 / std::sqrt(spread), 1e-9);
}

TEST(Rheology, SaysThatALossFactorOfSomethingElseDoesNotAgree) {
  const FrequencyDependence found =
      frequency_dependence({calibration(4, 0.01, 0.2, 0.002), calibration(40, 0.01, 0.2, 0.002)});
  EXPECT_NE(found.sentences[1].find("do not agree"), std::string::npos) << found.sentences[1];
}

TEST(Rheology, CallsAModulusConstantWithinItsSigmas) {
  // 200 draws of three constant moduli with their sigma: two sigmas are passed in 4.6 % of them,
  // give or take 1.5.
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  int changes = 0;
  constexpr int kDraws = 400;
  for (int i = 0; i < kDraws; ++i) {
    std::vector<NamedMaterial> all;
    for (const double f : {4.0, 12.0, 40.0}) {
      all.push_back(calibration(f, 0.0, 0.1, 0.01));
      all.back().material.youngs_modulus_identified_pa *= 1.0 + 0.01 * normal(generator);
    }
    changes += frequency_dependence(all).changes ? 1 : 0;
  }
  // Widening by the scatter makes it rarer: 2.5 to 4.6 %; three sigmas of 400 draws either side.
  EXPECT_LT(changes, kDraws * 0.08);
  EXPECT_GT(changes, 0);
}

TEST(Rheology, CountsDimensionsAsCommonToOnePiece) {
  std::vector<NamedMaterial> all = {calibration(4, 0.06, 0.1, 0.002),
                                    calibration(40, 0.06, 0.1, 0.002)};
  for (NamedMaterial& named : all) named.material.uncertainty.dimension = 0.13;
  EXPECT_FALSE(frequency_dependence(all).changes);
  EXPECT_TRUE(frequency_dependence(all, {.same_part = true}).changes);
}

TEST(Rheology, AsksNoSlopeOfOneFrequency) {
  const FrequencyDependence found =
      frequency_dependence({calibration(10, 0.0, 0.1, 0.01), calibration(10.2, 0.0, 0.1, 0.01)});
  EXPECT_FALSE(found.modulus.has_value());
  EXPECT_NE(found.sentences[0].find("too close together"), std::string::npos);
}

TEST(Rheology, RefusesAnotherMaterialAndALoneCalibration) {
  const NamedMaterial one = calibration(4, 0.0, 0.1, 0.01);
  NamedMaterial other = calibration(40, 0.0, 0.1, 0.01);
  other.material.material = "rubber";
  EXPECT_THROW((void)frequency_dependence({one}), InputError);
  EXPECT_THROW((void)frequency_dependence({one, other}), InputError);
  NamedMaterial empty = calibration(40, 0.0, 0.1, 0.01);
  empty.material.frequency_hz = kNaN;
  EXPECT_THROW((void)frequency_dependence({one, empty}), InputError);
}

}  // namespace
}  // namespace twang
