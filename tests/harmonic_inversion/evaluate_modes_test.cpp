// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/evaluate_modes.hpp"

#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

class EvaluatedModes : public testing::TestWithParam<double> {};

TEST_P(EvaluatedModes, EqualThoseAtSingleTimes) {
  SynthesisOptions options;
  options.drift_per_s = 0.1;
  options.noise_sigma = 0.01;
  options.jitter_s = GetParam();
  const Trace trace =
      synthesize_sinusoids({{20.0, 3.0, 1.0, 0.4}, {44.0, 9.0, 0.2, -2.0}}, options);
  const InversionResult result = invert_harmonics(trace, {"y"});
  ASSERT_EQ(result.modes.size(), 2U);
  Eigen::VectorXd time_s(static_cast<Eigen::Index>(trace.num_samples()));
  for (Eigen::Index i = 0; i < time_s.size(); ++i)
    time_s(i) = trace.time_s[static_cast<std::size_t>(i)] - result.origin_s(0);
  const Eigen::VectorXd values = evaluate_modes(result, 0, time_s);
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    // 64 products, and a phase of 550 rad.
    EXPECT_NEAR(values(i), result.evaluate(0, time_s(i) + result.origin_s(0)), 1e-12) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(EvenAndJittered, EvaluatedModes, testing::Values(0.0, 0.001));

}  // namespace
}  // namespace twang
