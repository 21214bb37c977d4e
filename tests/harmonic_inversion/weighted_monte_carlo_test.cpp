// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "harmonic_inversion/cramer_rao.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/refine_sinusoids.hpp"

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

/// What five of 481 samples that are off by 30 sigma do.
enum class Outliers { None, Alone, InARun };

class OutlierDraws : public testing::TestWithParam<Outliers> {};

TEST_P(OutlierDraws, CostNoMoreThanTheSamplesThatTheySpoil) {
  const SinusoidTruth truth{20.0, 4.0, 1.0, 0.6};
  SynthesisOptions options;
  options.noise_sigma = 0.03;
  const CramerRaoBound bound = cramer_rao_bounds({truth}, options).front();
  double squares = 0.0;
  double within = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    options.seed = static_cast<std::uint32_t>(9000 + draw);
    Trace trace = synthesize_sinusoids({truth}, options);
    std::mt19937 generator(options.seed);
    // Beyond the first few samples, where a run is as well explained by a mode that is soon gone.
    std::uniform_int_distribution<std::size_t> place(20, 475);
    const std::size_t first = place(generator);
    for (std::size_t i = 0; i < 5 && GetParam() != Outliers::None; ++i) {
      const bool run = GetParam() == Outliers::InARun;
      const double sign = run || i % 2 == 0 ? 1.0 : -1.0;
      trace.channels[0].values[run ? first + i : place(generator)] +=
          sign * 30.0 * options.noise_sigma;
    }
    const InversionResult result = invert_harmonics(trace, {"y"});
    ASSERT_TRUE(result.usable()) << draw;
    const DampedSinusoid& mode = result.modes.front();
    const double f_error = mode.frequency_hz - truth.frequency_hz;
    const double d_error = mode.decay_per_s - truth.decay_per_s;
    squares += std::pow(f_error / bound.frequency_hz, 2) + std::pow(d_error / bound.decay_per_s, 2);
    within += std::abs(f_error) < mode.frequency_sigma_hz ? 1.0 : 0.0;
    within += std::abs(d_error) < mode.decay_sigma_per_s ? 1.0 : 0.0;
  }
  // 400 values: 3.5 % of scatter, three of them, and what samples lost at the loud beginning cost.
  EXPECT_LT(std::sqrt(squares / (2.0 * kDraws)), 1.15);
  EXPECT_NEAR(within / (2.0 * kDraws), 0.683, 0.06);  // a scatter of 2.3 %
}

INSTANTIATE_TEST_SUITE_P(OfARecord,
                         OutlierDraws,
                         testing::Values(Outliers::None, Outliers::Alone, Outliers::InARun),
                         [](const auto& test) {
                           switch (test.param) {
                             case Outliers::None:
                               return "None";
                             case Outliers::Alone:
                               return "Alone";
                             default:
                               return "InARun";
                           }
                         });

TEST(CleanRecords, AreFittedAsByPlainLeastSquares) {
  const SinusoidTruth truth{20.0, 4.0, 1.0, 0.6};
  SynthesisOptions options;
  options.noise_sigma = 0.03;
  int compared = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    options.seed = static_cast<std::uint32_t>(100 + draw);
    const Trace trace = synthesize_sinusoids({truth}, options);
    const InversionResult result = invert_harmonics(trace, {"y"});
    if (result.modes.size() != 1U || result.drifts_per_s[0] != 0.0) continue;  // another model
    ++compared;
    const SampleSeries y{"y",
                         Eigen::Map<const Eigen::VectorXd>(trace.time_s.data(), 481),
                         Eigen::Map<const Eigen::VectorXd>(trace.channels[0].values.data(), 481)};
    const SinusoidFit plain = refine_sinusoids({y}, {{20.0, 4.0}});
    const DampedSinusoid& mode = result.modes.front();
    EXPECT_NEAR(mode.frequency_hz, plain.poles[0].frequency_hz, 0.1 * mode.frequency_sigma_hz);
    EXPECT_NEAR(mode.decay_per_s, plain.poles[0].decay_per_s, 0.1 * mode.decay_sigma_per_s);
  }
  EXPECT_GT(compared, kDraws * 9 / 10);
}

TEST(DerivedSigmas, AreTheScatterOfWhatTheyBelongTo) {
  // Heavy damping at an awkward phase: f and d are strongly correlated.
  const double decay = 0.3 * kTwoPi * 20.0;
  const SinusoidTruth truth{20.0, decay, 1.0, 0.2};
  DampedSinusoid exact;
  exact.frequency_hz = truth.frequency_hz;
  exact.decay_per_s = truth.decay_per_s;
  SynthesisOptions options;
  options.noise_sigma = 0.003;
  Eigen::Array4d squares = Eigen::Array4d::Zero();
  double correlation = 0.0;
  constexpr int kMany = 400;
  for (int draw = 0; draw < kMany; ++draw) {
    options.seed = static_cast<std::uint32_t>(20000 + draw);
    const InversionResult result = invert_harmonics(synthesize_sinusoids({truth}, options), {"y"});
    ASSERT_TRUE(result.usable()) << draw;
    const DampedSinusoid& m = result.modes.front();
    squares += Eigen::Array4d((m.damping_ratio() - exact.damping_ratio()) / m.damping_ratio_sigma(),
                              (m.lambda_per_s2() - exact.lambda_per_s2()) / m.lambda_sigma_per_s2(),
                              (m.natural_frequency_hz() - exact.natural_frequency_hz()) /
                                  m.natural_frequency_sigma_hz(),
                              (m.damping_stiffness_b_s() - exact.damping_stiffness_b_s()) /
                                  m.damping_stiffness_b_sigma_s())
                   .square();
    correlation +=
        m.frequency_decay_covariance / (m.frequency_sigma_hz * m.decay_sigma_per_s) / kMany;
  }
  // 400 draws know a standard deviation to 3.5 %: three of that.
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(std::sqrt(squares(i) / kMany), 1.0, 0.1) << i;
  // Or else the test could not tell independent f and d from these.
  EXPECT_GT(std::abs(correlation), 0.15);
}

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
