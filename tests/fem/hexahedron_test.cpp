// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/hexahedron.hpp"

#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using Eigen::Vector3d;

// Round-off of sums of up to 27 terms of order one.
constexpr double kRoundOff = 1e-14;

class EachKind : public ::testing::TestWithParam<ElementKind> {};
INSTANTIATE_TEST_SUITE_P(Hexahedron,
                         EachKind,
                         ::testing::Values(ElementKind::Hex8, ElementKind::Hex20),
                         [](const auto& kind) { return std::string(to_string(kind.param)); });

TEST_P(EachKind, ShapeFunctionIsOneAtItsNodeAndZeroAtTheOthers) {
  const int nodes = nodes_per_element(GetParam());
  for (int b = 0; b < nodes; ++b) {
    const Eigen::VectorXd N = shape_functions(GetParam(), reference_node(b));
    ASSERT_EQ(N.size(), nodes);
    for (int a = 0; a < nodes; ++a) EXPECT_NEAR(N[a], a == b ? 1.0 : 0.0, kRoundOff);
  }
}

TEST_P(EachKind, GradientsAreTheDerivativesOfTheShapeFunctions) {
  const Vector3d xi(0.31, -0.47, 0.83);
  const Eigen::Matrix3Xd dN = shape_gradients(GetParam(), xi);
  const double step = 1e-5;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d offset = step * Vector3d::Unit(axis);
    const Eigen::VectorXd slope =
        (shape_functions(GetParam(), xi + offset) - shape_functions(GetParam(), xi - offset)) /
        (2.0 * step);
    // Truncation step² = 1e-10 and round-off 1e-16 / step = 1e-11, times small factors.
    EXPECT_LT((dN.row(axis).transpose() - slope).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST_P(EachKind, ReproducesLinearFieldsAndHex20AlsoQuadraticOnes) {
  const auto field = [&](const Vector3d& x) {
    double value = 1.0 + 2.0 * x.x() - 3.0 * x.y() + 0.5 * x.z();
    if (GetParam() == ElementKind::Hex20) {
      value += x.x() * x.x() - 2.0 * x.y() * x.z() + 0.7 * x.z() * x.z() + x.x() * x.y() * x.z();
    }
    return value;
  };
  const Vector3d xi(-0.2, 0.55, 0.9);
  const Eigen::VectorXd N = shape_functions(GetParam(), xi);
  double sum = 0.0;
  for (int a = 0; a < N.size(); ++a) sum += N[a] * field(reference_node(a));
  EXPECT_NEAR(sum, field(xi), 10.0 * kRoundOff);
}

TEST_P(EachKind, QuadratureIsExactToDegreeThreeAndFive) {
  const int degree = GetParam() == ElementKind::Hex8 ? 3 : 5;
  const Quadrature& rule = quadrature(GetParam());
  ASSERT_EQ(rule.points.size(), GetParam() == ElementKind::Hex8 ? 8U : 27U);
  for (int i = 0; i <= degree + 1; ++i) {
    double sum = 0.0;
    for (std::size_t g = 0; g < rule.points.size(); ++g) {
      const Vector3d& x = rule.points[g];
      sum += rule.weights[g] * std::pow(x.x(), i) * x.y() * x.y() * (1.0 + x.z());
    }
    const double exact = i % 2 == 0 ? 2.0 / (i + 1.0) * (2.0 / 3.0) * 2.0 : 0.0;
    if (i <= degree) {
      EXPECT_NEAR(sum, exact, 10.0 * kRoundOff) << i;
    } else {
      EXPECT_GT(std::abs(sum - exact), 0.01) << "the rule is no better than it needs to be";
    }
  }
}

TEST(ElementKind, NamesReadBackAndOthersAreRefused) {
  EXPECT_EQ(element_kind_from("hex8"), ElementKind::Hex8);
  EXPECT_EQ(element_kind_from("hex20"), ElementKind::Hex20);
  EXPECT_EQ(to_string(ElementKind::Hex20), "hex20");
  const std::string message = test::refusal_of([] { (void)element_kind_from("hex27"); });
  EXPECT_TRUE(test::holds(message, "\"hex27\""));
}

}  // namespace
}  // namespace twang
