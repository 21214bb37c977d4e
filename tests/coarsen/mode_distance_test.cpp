// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/sample_shapes.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/constants.hpp"
#include "fem/hex_mesh.hpp"
#include "tests/coarsen/rigs_of_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace twang {
namespace {

using Eigen::Vector3d;
using Field = std::function<Vector3d(const Vector3d&)>;

const Vector3d kSize(0.1, 0.01, 0.01);

// Shapes of a square-section beam, linear in y and z so that hex8 carries them between its nodes
// along the sections; along x both meshes sample them at their nodes.
Vector3d bend_y(const Vector3d& x) {
  const double s = x.x() / kSize.x();
  return {-2.0 * s * (x.y() - 0.005) / kSize.x(), s * s, 0.0};
}
Vector3d bend_z(const Vector3d& x) {
  const double s = x.x() / kSize.x();
  return {-2.0 * s * (x.z() - 0.005) / kSize.x(), 0.0, s * s};
}
Vector3d twist(const Vector3d& x) {
  return Vector3d(0.0, -(x.z() - 0.005), x.y() - 0.005) * x.x() / (0.0071 * kSize.x());
}
Vector3d stretch(const Vector3d& x) { return {x.x() / kSize.x(), 0.0, 0.0}; }

MeshRung rung(double dx_m,
              const std::vector<Field>& shapes,
              const std::vector<double>& frequencies) {
  MeshRung result;
  result.mesh = mesh_part(test::beam(kSize, 0.0, 1000.0), dx_m, ElementKind::Hex8);
  const auto count = static_cast<Eigen::Index>(shapes.size());
  result.modes.lambda_per_s2.resize(count);
  result.modes.shapes.resize(result.mesh.num_dofs(), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    result.modes.lambda_per_s2(k) = std::pow(kTwoPi * frequencies[i], 2);
    for (int n = 0; n < result.mesh.num_nodes(); ++n) {
      result.modes.shapes.block<3, 1>(3 * n, k) = shapes[i](result.mesh.nodes.col(n));
    }
  }
  return result;
}

Field scaled(double factor, const Field& field) {
  return [=](const Vector3d& x) { return Vector3d(factor * field(x)); };
}
Field sum(double a, const Field& f, double b, const Field& g) {
  return [=](const Vector3d& x) { return Vector3d(a * f(x) + b * g(x)); };
}

TEST(SampleFields, EqualsLocatingEachPoint) {
  // Points inside, on the surface, beside it by less and by much more than a cell.
  const HexMesh mesh = mesh_part(test::l_rig(), 1.5e-3, ElementKind::Hex20);
  Eigen::MatrixXd fields(mesh.num_dofs(), 2);
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    const Vector3d x = mesh.nodes.col(n) * 100.0;
    fields.block<3, 1>(3 * n, 0) = Vector3d(x.x() * x.y(), x.z() * x.z(), x.x() - x.y());
    fields.block<3, 1>(3 * n, 1) = Vector3d(std::sin(x.x()), std::cos(x.z()), 1.0);
  }
  Eigen::Matrix3Xd points(3, 6);
  points.col(0) << 0.0457, 0.0111, 0.0123;
  points.col(1) << 0.0300, 0.0100, 0.0270;
  points.col(2) << 0.0469, 0.0100, 0.0105;
  points.col(3) << 0.0300, 0.0100, 0.0110;  // in the L's mouth
  points.col(4) << 0.0, 0.0, 0.0;
  points.col(5) << 0.1, 0.1, 0.1;
  const Eigen::MatrixXd samples = sample_fields(mesh, fields, points);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const MeshPoint point = locate(mesh, points.col(i));
    for (Eigen::Index k = 0; k < fields.cols(); ++k) {
      const Vector3d expected = interpolate(point, fields.col(k));
      const Vector3d sampled = samples.block<3, 1>(3 * i, k);
      EXPECT_LE((sampled - expected).norm(), 1e-9 * (1.0 + expected.norm())) << i;  // round-off
    }
  }
}

// A parabola along x by chords of 2.5 mm: its sagitta over the peak is (dx / L)² / 4 = 1.6e-4.
constexpr double kChord = 4e-4;

TEST(CompareModes, SignAndScaleOfAShapeMeanNothing) {
  const MeshRung fine = rung(0.00125, {bend_y, twist, stretch}, {10, 40, 90});
  const MeshRung coarse =
      rung(0.0025, {scaled(-3.0, bend_y), scaled(0.2, twist), scaled(-1.0, stretch)}, {12, 50, 99});
  const ModeComparison comparison = compare_modes(fine, coarse, 3);
  ASSERT_EQ(comparison.difference_by_mode.size(), 3U);
  EXPECT_LT(comparison.max_difference, kChord);
}

TEST(CompareModes, ShapesThatChangePlacesFindEachOther) {
  const MeshRung fine = rung(0.00125, {bend_y, twist, stretch}, {10, 40, 90});
  const MeshRung coarse = rung(0.0025, {bend_y, stretch, bend_z, twist}, {12, 50, 60, 99});
  EXPECT_LT(compare_modes(fine, coarse, 3).max_difference, kChord);
}

TEST(CompareModes, NearEqualFrequenciesAreOneSubspace) {
  const double c = std::cos(0.7);
  const double s = std::sin(0.7);
  const MeshRung fine = rung(0.00125, {bend_y, bend_z, twist}, {10, 10.01, 40});
  const MeshRung turned =
      rung(0.0025, {sum(c, bend_y, s, bend_z), sum(-s, bend_y, c, bend_z), twist}, {12, 12.01, 50});
  EXPECT_LT(compare_modes(fine, turned, 3).max_difference, kChord);

  // The same shapes with frequencies far apart are different modes.
  const MeshRung apart_fine = rung(0.00125, {bend_y, bend_z, twist}, {10, 15, 40});
  const MeshRung apart_turned =
      rung(0.0025, {sum(c, bend_y, s, bend_z), sum(-s, bend_y, c, bend_z), twist}, {12, 18, 50});
  EXPECT_GT(compare_modes(apart_fine, apart_turned, 3).max_difference, 0.3);
}

TEST(CompareModes, ASubspaceThatLacksADirectionDoesNotAgree) {
  const MeshRung fine = rung(0.00125, {bend_y, bend_z}, {10, 10.01});
  const MeshRung coarse = rung(0.0025, {bend_y, twist}, {12, 12.01});
  const ModeComparison comparison = compare_modes(fine, coarse, 2);
  EXPECT_LT(comparison.difference_by_mode[0], kChord);
  EXPECT_GT(comparison.difference_by_mode[1], 0.5);
}

TEST(CompareModes, MeasuresAKnownDifference) {
  // A bump e s (1 - s) vanishes where the shape peaks, so that no scaling hides it; it is largest,
  // e / 4, in the middle.
  const double e = 0.2;
  const Field bump = [=](const Vector3d& x) {
    const double s = x.x() / kSize.x();
    return Vector3d(0.0, 0.0, e * s * (1.0 - s));
  };
  const MeshRung fine = rung(0.00125, {bend_y}, {10});
  const MeshRung coarse = rung(0.0025, {sum(1.0, bend_y, 1.0, bump)}, {12});
  const ModeComparison comparison = compare_modes(fine, coarse, 1);
  EXPECT_NEAR(comparison.max_difference, e / 4.0, kChord);
}

TEST(CompareModes, TheSetDistanceIsNeverTheStricterOne) {
  const MeshRung fine = rung(0.00125, {bend_y, twist, stretch}, {10, 40, 90});
  const MeshRung coarse = rung(0.005,
                               {sum(1.0, bend_y, 0.1, stretch),
                                sum(1.0, twist, 0.1, bend_z),
                                sum(1.0, stretch, 0.1, bend_y)},
                               {12, 50, 99});
  const ModeComparison comparison = compare_modes(fine, coarse, 3);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LE(comparison.hausdorff_by_mode[i], comparison.difference_by_mode[i] + 1e-12);
    EXPECT_GT(comparison.hausdorff_by_mode[i], 0.0);
  }
  EXPECT_GT(comparison.max_difference, 0.05);
}

}  // namespace
}  // namespace twang
