// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "harmonic_inversion/inversion_window.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/sample_scatter.hpp"
#include "harmonic_inversion/synthesize.hpp"
#include "harmonic_inversion/weighted_data.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace twang {
namespace {

using Eigen::VectorXd;

Trace noisy_trace() {
  SynthesisOptions options;
  options.noise_sigma = 0.02;
  return synthesize_sinusoids({{20.0, 4.0, 1.0, 0.6}, {47.0, 9.0, 0.2, 0.1}}, options);
}

void add_column(Trace& trace, const std::string& name, double value) {
  trace.channels.push_back({name, std::vector<double>(trace.num_samples(), value)});
}

std::string refusal_of(const Trace& trace, const InversionOptions& options = {}) {
  try {
    static_cast<void>(invert_harmonics(trace, {"y"}, options));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(StatedSigmas, ThatAreAllTheSameChangeNothing) {
  Trace trace = noisy_trace();
  const InversionResult without = invert_harmonics(trace, {"y"});
  add_column(trace, "y.sigma_v", 0.5);  // whatever it is
  const InversionResult with = invert_harmonics(trace, {"y"});
  ASSERT_EQ(with.modes.size(), 2U);
  ASSERT_EQ(without.modes.size(), 2U);
  // The very same operations: to the last digit.
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(with.modes[k].frequency_hz, without.modes[k].frequency_hz);
    EXPECT_EQ(with.modes[k].decay_per_s, without.modes[k].decay_per_s);
    EXPECT_EQ(with.modes[k].decay_sigma_per_s, without.modes[k].decay_sigma_per_s);
  }
  EXPECT_EQ(with.weights[0].sigma_column, "");
}

TEST(StatedSigmas, ThatDifferByLittleChangeLittle) {
  Trace trace = noisy_trace();
  const InversionResult without = invert_harmonics(trace, {"y"});
  add_column(trace, "y.sigma_v", 0.5);
  trace.channels[1].values[100] = 0.6;  // the weight of one sample of 481 by a third less
  const InversionResult with = invert_harmonics(trace, {"y"});
  ASSERT_EQ(with.modes.size(), 2U);
  EXPECT_EQ(with.weights[0].sigma_column, "y.sigma_v");
  // One sample moves an estimate from 481 by about 1 / sqrt(481) = 0.05 of its sigma.
  EXPECT_NEAR(with.modes[0].decay_per_s,
              without.modes[0].decay_per_s,
              0.1 * without.modes[0].decay_sigma_per_s);
  EXPECT_NEAR(with.modes[0].decay_sigma_per_s / without.modes[0].decay_sigma_per_s, 1.0, 0.01);
}

TEST(StatedSigmas, ThatAreAllTheSameKeepTheQuickWayOfLongEvenRecords) {
  SynthesisOptions options;
  options.duration_s = 50.0;
  options.noise_sigma = 0.1;
  Trace trace = synthesize_sinusoids({{20.0, 0.1, 1.0, 0.6}}, options);
  add_column(trace, "y.sigma_v", 0.1);
  const InversionWindow even = choose_window({&trace, 1}, {"y"}, {});
  EXPECT_NE(WeightedData(even.series, even.step_s).trial_options().records.at(0), nullptr);
  // And those that differ do not pass for even.
  trace.channels[1].values[200] = 10.0;
  const InversionWindow uneven = choose_window({&trace, 1}, {"y"}, {});
  EXPECT_EQ(WeightedData(uneven.series, uneven.step_s).trial_options().records.at(0), nullptr);
}

TEST(StatedSigmas, OfZeroOrBelowAreRefusedAtTheirTime) {
  for (const double bad : {0.0, -0.25}) {
    Trace trace = noisy_trace();
    add_column(trace, "y.sigma_v", 0.02);
    trace.channels[1].values[120] = bad;
    const std::string said = refusal_of(trace);
    EXPECT_NE(said.find("y.sigma_v"), std::string::npos) << said;
    EXPECT_NE(said.find(bad == 0.0 ? " 0 at 0.5 s (row 121)" : " -0.25 at 0.5 s (row 121)"),
              std::string::npos)
        << said;
    trace.channels[0].values[120] = kNaN;  // of a missing sample nothing is asked
    EXPECT_EQ(refusal_of(trace), "");
  }
}

TEST(StatedSigmas, ThatAreNotKnownMakeTheirSamplesMissing) {
  Trace trace = noisy_trace();
  add_column(trace, "y.sigma_v", 0.02);
  trace.channels[1].values[10] = 0.03;
  Trace cleared = trace;
  for (std::size_t i = 40; i < 60; ++i) {
    trace.channels[1].values[i] = i % 2 == 0 ? kNaN : kInfinity;
    trace.channels[0].values[i] = 1000.0;  // would spoil the fit
    cleared.channels[0].values[i] = kNaN;
  }
  const InversionResult unknown = invert_harmonics(trace, {"y"});
  const InversionResult missing = invert_harmonics(cleared, {"y"});
  ASSERT_EQ(unknown.modes.size(), missing.modes.size());
  EXPECT_EQ(unknown.modes[0].frequency_hz, missing.modes[0].frequency_hz);
  EXPECT_EQ(unknown.num_samples, 461);
  EXPECT_TRUE(
      std::any_of(unknown.remarks.begin(), unknown.remarks.end(), [](const std::string& remark) {
        return remark.find("20 samples of y without a standard deviation in y.sigma_v") == 0;
      }));
}

TEST(StatedSigmas, ComeFromTheColumnNamed) {
  Trace trace = noisy_trace();
  add_column(trace, "y.sigma_v", 0.02);
  add_column(trace, "error", 0.02);
  trace.channels[2].values[10] = 0.03;
  InversionOptions options;
  options.sigma_columns = {"error"};
  EXPECT_EQ(invert_harmonics(trace, {"y"}, options).weights[0].sigma_column, "error");
  options.sigma_columns = {"absent"};
  EXPECT_NE(refusal_of(trace, options).find("column absent"), std::string::npos);
  options.sigma_columns = {"error", "error"};
  EXPECT_NE(refusal_of(trace, options).find("2 columns"), std::string::npos);
  for (double& value : trace.channels[2].values) value = kNaN;
  options.sigma_columns = {"error"};
  EXPECT_NE(refusal_of(trace, options).find("column error holds no number"), std::string::npos);
  // The trace's own that holds no number states nothing.
  for (double& value : trace.channels[1].values) value = kNaN;
  EXPECT_EQ(invert_harmonics(trace, {"y"}).weights[0].sigma_column, "");
}

/// Residuals of standard deviation hypot(factor sigma, extra), and sigma.
struct Residuals {
  VectorXd value;
  VectorXd sigma;
};

Residuals residuals(double factor, double extra, Eigen::Index count) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.1, 2.0);
  Residuals out{VectorXd(count), VectorXd(count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    out.sigma(i) = uniform(generator);
    out.value(i) = std::hypot(factor * out.sigma(i), extra) * normal(generator);
  }
  return out;
}

TEST(SampleScatter, MakesChiSquarePerDegreeOfFreedomOne) {
  for (const auto& [factor, extra] : {std::pair{1.0, 0.7}, {1.0, 5.0}, {0.4, 0.0}}) {
    const Residuals r = residuals(factor, extra, 20000);
    const SampleScatter found = scatter_by_squares(r.value, r.sigma, 19990.0);
    const VectorXd variances = found.variances(r.sigma, 20000);
    // The defining equation, to the step at which the iteration stops.
    EXPECT_NEAR(r.value.cwiseAbs2().cwiseQuotient(variances).sum() / 19990.0, 1.0, 1e-9);
    // 20,000 residuals know their scatter to 0.5 %, a part of it a little worse.
    EXPECT_NEAR(found.factor, factor, 0.01);
    EXPECT_NEAR(found.extra, extra, 0.02 * std::max(extra, 1.0));
  }
}

TEST(SampleScatter, ByTheMedianIsNotMovedByOutliers) {
  Residuals r = residuals(1.0, 0.7, 20000);
  for (Eigen::Index i = 0; i < 200; ++i) r.value(97 * i) += 100.0;
  // One in a hundred moves the median by 1 % of the samples: 2 % of the scatter, 4 % of its square.
  EXPECT_NEAR(scatter_by_median(r.value, r.sigma).extra, 0.7, 0.05);
  EXPECT_GT(scatter_by_squares(r.value, r.sigma, 20000.0).extra, 5.0);
  const Residuals quiet = residuals(0.4, 0.0, 20000);
  EXPECT_NEAR(scatter_by_median(quiet.value, quiet.sigma).factor, 0.4, 0.01);
}

TEST(SampleScatter, WithoutSigmasIsTheRootMeanSquare) {
  const VectorXd r = VectorXd::LinSpaced(9, -4.0, 4.0);
  const SampleScatter found = scatter_by_squares(r, {}, 15.0);
  EXPECT_DOUBLE_EQ(found.extra, 2.0);  // sqrt(60 / 15)
  EXPECT_EQ(found.variances({}, 9), VectorXd::Constant(9, 4.0));
}

}  // namespace
}  // namespace twang
