// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/cramer_rao.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

namespace twang {
namespace {

constexpr int kDraws = 200;

/// Noise ten times as large in one third of a record.
struct NoisyThird {
  std::string name;
  int third = 0;        ///< 0 is the first
  double factor = 1.0;  ///< noise over what is stated
  double extra = 0.0;   ///< noise in all samples that is not stated
};

struct Errors {
  double rmse_over_bound = 0.0;  ///< of d
  double within_one = 0.0;       ///< of f and d
};

class NoisyThirds : public testing::TestWithParam<NoisyThird> {
 protected:
  static constexpr SinusoidTruth kTruth{20.0, 4.0, 1.0, 0.6};

  /// The errors over all draws, with or without the column of sigmas.
  static Errors draw(const NoisyThird& noise, bool weighted) {
    SynthesisOptions options;
    options.offset = 0.3;
    const Trace clean = synthesize_sinusoids({kTruth}, options);
    const std::size_t n = clean.num_samples();
    Channel stated{"y.sigma_v", std::vector<double>(n, 0.01)};
    const auto first = static_cast<std::size_t>(noise.third) * n / 3;
    for (std::size_t i = first; i < first + n / 3; ++i) stated.values[i] *= 10.0;
    Eigen::VectorXd sigma(static_cast<Eigen::Index>(n));
    for (std::size_t i = 0; i < n; ++i)
      sigma(static_cast<Eigen::Index>(i)) =
          std::hypot(noise.factor * stated.values[i], noise.extra);
    const Eigen::Map<const Eigen::VectorXd> time(clean.time_s.data(), sigma.size());
    const CramerRaoBound bound = cramer_rao_bounds({kTruth}, time, sigma).front();
    Errors out;
    for (int draw = 0; draw < kDraws; ++draw) {
      std::mt19937 generator(static_cast<std::uint32_t>(4000 + draw));
      std::normal_distribution<double> normal;
      Trace trace = clean;
      for (std::size_t i = 0; i < n; ++i)
        trace.channels[0].values[i] += sigma(static_cast<Eigen::Index>(i)) * normal(generator);
      if (weighted) trace.channels.push_back(stated);
      const InversionResult result = invert_harmonics(trace, {"y"});
      if (!result.usable()) {
        ADD_FAILURE() << "draw " << draw << ": " << result.message;
        continue;
      }
      const DampedSinusoid& mode = result.modes.front();
      const double d_error = mode.decay_per_s - kTruth.decay_per_s;
      const double f_error = mode.frequency_hz - kTruth.frequency_hz;
      out.rmse_over_bound += std::pow(d_error / bound.decay_per_s, 2) / kDraws;
      out.within_one += std::abs(d_error) < mode.decay_sigma_per_s ? 0.5 / kDraws : 0.0;
      out.within_one += std::abs(f_error) < mode.frequency_sigma_hz ? 0.5 / kDraws : 0.0;
    }
    out.rmse_over_bound = std::sqrt(out.rmse_over_bound);
    return out;
  }
};

TEST_P(NoisyThirds, CostLittleWhereTheSigmasAreStatedAndTheResultSaysHowMuch) {
  const Errors weighted = draw(GetParam(), true);
  const Errors alike = draw(GetParam(), false);
  // The rmse of 200 draws scatters by 5 %: 15 % are three of that.
  EXPECT_LT(weighted.rmse_over_bound, 1.15);
  EXPECT_GT(weighted.rmse_over_bound, 0.85);
  // What it costs to take all samples alike is far more than the scatter.
  EXPECT_GT(alike.rmse_over_bound, 1.4 * weighted.rmse_over_bound);
  // 68.3 % of 400 values scatter by 2.3 %; 62 to 74 % are 2.5 of that.
  EXPECT_NEAR(weighted.within_one, 0.683, 0.06);
}

INSTANTIATE_TEST_SUITE_P(OfARecord,
                         NoisyThirds,
                         testing::Values(NoisyThird{"First", 0},
                                         NoisyThird{"Middle", 1},
                                         NoisyThird{"MiddleHalfTheNoiseStated", 1, 0.5},
                                         NoisyThird{"MiddleAndNoiseThatIsNotStated", 1, 1.0, 0.01}),
                         [](const auto& test) { return test.param.name; });

TEST(CramerRaoOfUnevenNoise, IsThatOfEvenNoiseWhereItIsEven) {
  SynthesisOptions options;
  options.noise_sigma = 0.02;
  const SinusoidTruth truth{20.0, 4.0, 1.0, 0.6};
  const Trace trace = synthesize_sinusoids({truth}, options);
  const Eigen::Map<const Eigen::VectorXd> time(trace.time_s.data(), 481);
  const CramerRaoBound even = cramer_rao_bounds({truth}, options).front();
  const CramerRaoBound same =
      cramer_rao_bounds({truth}, time, Eigen::VectorXd::Constant(481, 0.02)).front();
  EXPECT_NEAR(same.frequency_hz / even.frequency_hz, 1.0, 1e-9);  // round-off of a QR
  EXPECT_NEAR(same.decay_per_s / even.decay_per_s, 1.0, 1e-9);
  // Samples of hardly any weight are samples that are not there.
  Eigen::VectorXd sigma = Eigen::VectorXd::Constant(481, 0.02);
  sigma.tail(240).setConstant(1e6);
  options.duration_s = 1.0;
  const CramerRaoBound half = cramer_rao_bounds({truth}, options).front();
  EXPECT_NEAR(
      cramer_rao_bounds({truth}, time, sigma).front().decay_per_s / half.decay_per_s, 1.0, 1e-6);
}

}  // namespace
}  // namespace twang
