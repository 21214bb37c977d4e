// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/attach_weights.hpp"

#include "fem/eigenmodes.hpp"
#include "tests/simulate/box_body.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace twang {
namespace {

using Eigen::Vector3d;

const Vector3d kBlock_m(0.03, 0.03, 0.06);
constexpr double kWeight_kg = 0.05;
const ElasticMaterial kRubber = {3e5, 0.45, 1000.0, 0.0, 0.0};

ElasticBody block(int cells) {
  return ElasticBody(test::box_mesh(ElementKind::Hex20, {cells, cells, 2 * cells}, kBlock_m),
                     {kRubber});
}

/// Mass and first moments of all weights of a body.
std::pair<double, Vector3d> sum_of(const std::vector<WeightAtPoint>& weights, const HexMesh& mesh) {
  double mass = 0.0;
  Vector3d moment = Vector3d::Zero();
  for (const WeightAtPoint& weight : weights) {
    mass += weight.mass_kg;
    for (std::size_t i = 0; i < weight.point.nodes.size(); ++i)
      moment += weight.mass_kg * weight.point.weights[static_cast<Eigen::Index>(i)] *
                mesh.nodes.col(weight.point.nodes[i]);
  }
  return {mass, moment};
}

TEST(AttachWeights, SpreadsEvenlyOverItsBox) {
  const ElasticBody body = block(3);
  const Vector3d at(0.012, 0.015, 0.06);
  for (const Vector3d& size : {Vector3d(0.0, 0.0, 0.0), Vector3d(0.01, 0.02, 0.0)}) {
    const auto [mass, moment] =
        sum_of(weights_at_points(body.mesh(), {{at, kWeight_kg, size}}), body.mesh());
    EXPECT_NEAR(mass, kWeight_kg, 1e-12);
    EXPECT_LT((moment / mass - at).norm(), 1e-12);
  }
  // Half of this box is above the block: what is within carries all.
  const auto [mass, moment] =
      sum_of(weights_at_points(body.mesh(), {{at, kWeight_kg, {0.01, 0.02, 0.02}}}), body.mesh());
  EXPECT_NEAR(mass, kWeight_kg, 1e-12);
  EXPECT_NEAR((moment / mass).z(), 0.055, 1e-12);
}

TEST(AttachWeights, AWeightWithASizeHasALimitAndOneAtAPointHasNot) {
  const auto change = [](const Vector3d& size) {
    std::vector<double> lambda;
    for (const int cells : {4, 8}) {
      ElasticBody body = block(cells);
      attach_weights(body, {{{0.015, 0.015, 0.06}, kWeight_kg, size}});
      EigenmodeOptions options;
      options.count = 1;
      lambda.push_back(
          compute_eigenmodes(body, test::nodes_at(body.mesh(), 2, 0.0), options).lambda_per_s2(0));
    }
    return lambda[1] / lambda[0] - 1.0;
  };
  const double of_patch = change({0.02, 0.02, 0.0});
  const double of_point = change(Vector3d::Zero());
  std::printf("first eigenvalue on cells of half the size: patch %+.2f %%, point %+.2f %%\n",
              100.0 * of_patch,
              100.0 * of_point);
  // hex20 at a patch's edge, and at nearly incompressible rubber, is itself a few per cent off
  EXPECT_LT(std::abs(of_patch), 0.03);
  EXPECT_LT(of_point, -0.1);
}

TEST(AttachWeights, RefusesAWeightThatTouchesNothing) {
  const ElasticBody body = block(2);
  const std::string said = test::refusal_of([&] {
    static_cast<void>(
        weights_at_points(body.mesh(), {{{0.015, 0.015, 0.09}, kWeight_kg, {0.01, 0.01, 0.01}}}));
  });
  EXPECT_TRUE(test::holds(said, "50 g")) << said;
  EXPECT_TRUE(test::holds(said, "touches none of the part")) << said;
}

}  // namespace
}  // namespace twang
