// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/detail/followed_residuals.hpp"

#include "tests/calibrate/small_l_rig.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

namespace twang {
namespace {

using detail::FollowedResiduals;
using detail::Parameters;
using test::quick;
using test::SwingingRig;

/// What follows a swing of that amplitude.
struct Followed {
  Rig rig = test::small_l_rig();
  MeshRung rung = compute_rung(rig, test::kCell_m, ElementKind::Hex8, 2);
  SwingingRig seen;
  Material linear;
  RefineMaterialOptions options = quick();
  std::optional<FollowedResiduals> residuals;

  explicit Followed(double amplitude_rad, const std::function<void(Trace&)>& spoil = {})
      : seen(0.5, amplitude_rad), linear(test::linear_estimate(rig, rung, seen.inversion)) {
    if (spoil) spoil(seen.trace);
    residuals.emplace(rig,
                      rung,
                      linear,
                      RefinedRecording{&seen.trace, "observable_rad", &seen.inversion},
                      0,
                      options,
                      [] {});
  }
};

TEST(FollowedResiduals, AModulusDilatesALargeMotionInTime) {
  Followed followed(0.3);
  const Parameters at(0.01, -0.05, 0.0, 0.7);  // far from rest and from standstill
  const std::optional<Eigen::MatrixXd> columns = followed.residuals->derivatives(at);
  ASSERT_TRUE(columns) << followed.residuals->message();
  constexpr double kStep = 0.005;
  const auto simulated = [&](double ln_modulus) {
    Parameters moved = at;
    moved[0] += ln_modulus;
    return followed.residuals->values(moved)->simulated;
  };
  const Eigen::VectorXd slope = (simulated(kStep) - simulated(-kStep)) / (2.0 * kStep);
  EXPECT_LT((columns->col(0) - slope).norm(), 0.01 * slope.norm());
}

TEST(FollowedResiduals, SamplesFarOffAreLeftOutUnlessTheyAreMany) {
  const auto spoil_every = [](int n) {
    return [n](Trace& trace) {
      for (std::size_t i = 30; i < trace.num_samples(); i += static_cast<std::size_t>(n))
        trace.channels[0].values[i] += 0.05;
    };
  };
  Followed two(0.01, spoil_every(45));
  const Eigen::Index all = two.residuals->samples().num_used();
  EXPECT_EQ(two.residuals->leave_out_outliers(Parameters::Zero()), 2);
  EXPECT_EQ(two.residuals->samples().num_used(), all - 2);
  Followed many(0.01, spoil_every(6));
  EXPECT_EQ(many.residuals->leave_out_outliers(Parameters::Zero()), 0);
}

TEST(FollowedResiduals, GoNoFartherThanALargeMotionLeadsALinearEstimateAstray) {
  Followed followed(0.01);
  EXPECT_EQ(followed.residuals->values(Parameters(std::log(1.6), 0.0, 0.0, 0.0)), nullptr);
  EXPECT_TRUE(test::holds(followed.residuals->message(), "factor of 1.5"));
  EXPECT_EQ(followed.residuals->values(Parameters(0.0, -std::log(4.1), 0.0, 0.0)), nullptr);
  EXPECT_NE(followed.residuals->values(Parameters(0.01, 0.01, 0.0, 0.0)), nullptr);
}

}  // namespace
}  // namespace twang
