// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace twang {
namespace {

using Json = nlohmann::json;

InversionResult example() {
  SynthesisOptions options;
  options.noise_sigma = 0.01;
  return invert_harmonics(
      synthesize_sinusoids({{20.0, 3.0, 1.0, 0.4}, {44.0, 9.0, 0.2, -2.0}}, options), {"y"});
}

TEST(ModesJson, CarriesEveryFieldOfTheFormatAndReadsBackExactly) {
  const InversionResult result = example();
  const Json json = Json::parse(modes_to_json(result));
  EXPECT_EQ(json["format"], "twang-modes/1");
  EXPECT_EQ(json["time_origin_s"].get<double>(), result.time_origin_s);
  EXPECT_EQ(json["residual_rms"].get<double>(), result.residual_rms);
  EXPECT_EQ(json["snr_db"].get<double>(), result.snr_db);
  EXPECT_EQ(json["method"], result.method);
  EXPECT_TRUE(json["rejected"].is_array());
  ASSERT_EQ(json["modes"].size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    const Json& mode = json["modes"][k];
    const DampedSinusoid& expected = result.modes[k];
    EXPECT_EQ(mode["frequency_hz"].get<double>(), expected.frequency_hz);
    EXPECT_EQ(mode["frequency_sigma_hz"].get<double>(), expected.frequency_sigma_hz);
    EXPECT_EQ(mode["decay_per_s"].get<double>(), expected.decay_per_s);
    EXPECT_EQ(mode["decay_sigma_per_s"].get<double>(), expected.decay_sigma_per_s);
    EXPECT_EQ(mode["natural_frequency_hz"].get<double>(), expected.natural_frequency_hz());
    EXPECT_EQ(mode["damping_ratio"].get<double>(), expected.damping_ratio());
    EXPECT_EQ(mode["damping_ratio_sigma"].get<double>(), expected.damping_ratio_sigma());
    EXPECT_EQ(mode["natural_frequency_sigma_hz"].get<double>(),
              expected.natural_frequency_sigma_hz());
    EXPECT_EQ(mode["lambda_per_s2"].get<double>(), expected.lambda_per_s2());
    EXPECT_EQ(mode["lambda_sigma_per_s2"].get<double>(), expected.lambda_sigma_per_s2());
    EXPECT_EQ(mode["damping_stiffness_b_s"].get<double>(), expected.damping_stiffness_b_s());
    EXPECT_EQ(mode["damping_stiffness_b_sigma_s"].get<double>(),
              expected.damping_stiffness_b_sigma_s());
    EXPECT_EQ(mode["channels"]["y"]["amplitude"].get<double>(), expected.channels[0].amplitude);
    EXPECT_EQ(mode["channels"]["y"]["phase_rad"].get<double>(), expected.channels[0].phase_rad);
    EXPECT_TRUE(mode.contains("error"));
  }
  // 20 log10(A1 / residual): 1 over 0.01 is 40 dB, with 1 % of scatter.
  EXPECT_NEAR(json["snr_db"].get<double>(), 40.0, 0.5);
}

TEST(ModesJson, SaysHowTheSamplesWereWeighed) {
  InversionResult result = example();
  result.weights = {{"y", "y.sigma_mm", 1.0, 0.25, 3, 2}};
  const Json stated = Json::parse(modes_to_json(result))["weights"]["y"];
  EXPECT_EQ(stated["sigma_column"], "y.sigma_mm");
  EXPECT_EQ(stated["sigma_factor"].get<double>(), 1.0);
  EXPECT_EQ(stated["extra_sigma"].get<double>(), 0.25);
  EXPECT_EQ(stated["left_out"].get<int>(), 3);
  EXPECT_EQ(stated["down_weighted"].get<int>(), 2);
  const Json alike = Json::parse(modes_to_json(example()))["weights"]["y"];
  EXPECT_TRUE(alike["sigma_column"].is_null());
  EXPECT_TRUE(alike["sigma_factor"].is_null());
}

TEST(ModesJson, WritesNullForWhatIsNotFinite) {
  InversionResult result = example();
  result.modes[0].error = kNaN;
  result.snr_db = kInfinity;
  const Json json = Json::parse(modes_to_json(result));
  EXPECT_TRUE(json["modes"][0]["error"].is_null());
  EXPECT_TRUE(json["snr_db"].is_null());
}

TEST(ModesJson, CarriesTheDecayChecksWhereThereAreSome) {
  InversionResult result = example();
  EXPECT_FALSE(Json::parse(modes_to_json(result)).contains("decay_checks"));
  DecayCheck good;
  good.method += "Morlet wavelet";
  good.channel += "y";
  good.frequency_hz = 20.25;
  good.frequency_sigma_hz = 0.5;
  good.decay_per_s = 3.125;
  good.decay_sigma_per_s = 0.0625;
  good.num_points = 17;
  DecayCheck none;
  none.message += "too short";
  result.decay_checks = {good, none};
  const Json checks = Json::parse(modes_to_json(result))["decay_checks"];
  ASSERT_EQ(checks.size(), 2U);
  EXPECT_EQ(checks[0]["method"], good.method);
  EXPECT_EQ(checks[0]["channel"], good.channel);
  EXPECT_EQ(checks[0]["frequency_hz"].get<double>(), good.frequency_hz);
  EXPECT_EQ(checks[0]["frequency_sigma_hz"].get<double>(), good.frequency_sigma_hz);
  EXPECT_EQ(checks[0]["decay_per_s"].get<double>(), good.decay_per_s);
  EXPECT_EQ(checks[0]["decay_sigma_per_s"].get<double>(), good.decay_sigma_per_s);
  EXPECT_EQ(checks[0]["num_points"].get<int>(), good.num_points);
  EXPECT_TRUE(checks[1]["decay_per_s"].is_null());
  EXPECT_EQ(checks[1]["message"], none.message);
}

TEST(ModesJson, PutsSeveralColumnsSideBySide) {
  InversionResult none;
  none.message = "no mode";
  const Json json = Json::parse(modes_to_json({{"a", example()}, {"b", none}}));
  EXPECT_EQ(json["format"], "twang-modes/1");
  EXPECT_EQ(json["columns"]["a"]["modes"].size(), 2U);
  EXPECT_TRUE(json["columns"]["b"]["modes"].is_array());
  EXPECT_TRUE(json["columns"]["b"]["modes"].empty());
  EXPECT_FALSE(json.contains("modes"));
}

TEST(SynthesizeSinusoids, IsTheFormulaItStates) {
  SynthesisOptions options;
  options.offset = 0.3;
  options.drift_per_s = -0.5;
  options.held_s = 0.25;
  const Trace trace = synthesize_sinusoids({{20.0, 3.0, 1.5, 0.4}}, options);
  ASSERT_EQ(trace.num_samples(), 481U);
  const double s = 0.5 - 0.25;
  EXPECT_NEAR(trace.channels[0].values[120],
              0.3 - 0.25 + 1.5 * std::exp(-3.0 * s) * std::sin(kTwoPi * 20.0 * s + 0.4),
              1e-14);
  EXPECT_NEAR(trace.channels[0].values[0], 0.3 + 1.5 * std::sin(0.4), 1e-15);
}

TEST(SynthesizeSinusoids, RepeatsItselfForASeedAndRefusesBadOptions) {
  SynthesisOptions options;
  options.noise_sigma = 0.1;
  options.seed = 9;
  const auto once = synthesize_sinusoids({}, options).channels[0].values;
  EXPECT_EQ(once, synthesize_sinusoids({}, options).channels[0].values);
  options.seed = 10;
  EXPECT_NE(once, synthesize_sinusoids({}, options).channels[0].values);
  const auto refused = [](auto&& spoil) {
    SynthesisOptions bad;
    EXPECT_NO_THROW(bad.check());
    spoil(bad);
    EXPECT_ANY_THROW(bad.check());
  };
  refused([](SynthesisOptions& o) { o.rate_hz = 0.0; });
  refused([](SynthesisOptions& o) { o.duration_s = -1.0; });
  refused([](SynthesisOptions& o) { o.noise_sigma = -1.0; });
  refused([](SynthesisOptions& o) { o.jitter_s = 0.5 / o.rate_hz; });
  refused([](SynthesisOptions& o) { o.held_s = -1.0; });
  refused([](SynthesisOptions& o) { o.missing_part = 1.0; });
}

}  // namespace
}  // namespace twang
