// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "fem/hex_mesh.hpp"
#include "tests/fem/distorted_mesh.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A linear field, which every element has exactly.
VectorXd linear_field(const HexMesh& mesh, const Matrix3d& A, const Vector3d& t) {
  return ((A * mesh.nodes).colwise() + t).reshaped();
}

Matrix3d some_matrix() {
  Matrix3d A;
  A << 1, -2, 0.5, 3, 0.1, 1, -1, 2, 4;
  return A;
}

TEST(Locate, FindsAPointFromItsOwnShapeFunctions) {
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    const HexMesh mesh = test::distorted_mesh(kind, 0.2);
    const Vector3d xi(0.3, -0.6, 0.8);
    for (int e = 0; e < mesh.num_elements(); ++e) {
      const VectorXd N = shape_functions(kind, xi);
      Vector3d x = Vector3d::Zero();
      for (int a = 0; a < N.size(); ++a) x += N[a] * mesh.nodes.col(mesh.elements(a, e));
      const MeshPoint point = locate(mesh, x);
      EXPECT_EQ(point.element, e);
      EXPECT_LT((point.xi - xi).norm(), 1e-8);
      EXPECT_EQ(point.distance_m, 0.0);
      EXPECT_LT((point.weights - N).norm(), 1e-8);
    }
  }
}

TEST(Locate, ReproducesLinearFieldsInsideAndBesideTheMesh) {
  const Vector3d t(1, -2, 3);
  const Matrix3d A = some_matrix();
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    for (const double distortion : {0.0, 0.2}) {
      const HexMesh mesh = test::distorted_mesh(kind, distortion);
      const VectorXd field = linear_field(mesh, A, t);
      for (const Vector3d& x : {Vector3d(0.7, 1.4, 1.9),
                                Vector3d(1.0, 2.0, 1.0),
                                Vector3d(-3.0, 1.5, 0.5),
                                Vector3d(4.0, 5.0, -2.0)}) {
        const MeshPoint point = locate(mesh, x);
        EXPECT_LT((interpolate(point, field) - (A * x + t)).norm(), 1e-12);
        EXPECT_LT((interpolate_gradient(point, field) - A).norm(), 1e-12);
        EXPECT_NEAR(point.weights.sum(), 1.0, 1e-13);
      }
    }
  }
}

TEST(Locate, TellsTheDistanceBesideTheMesh) {
  const HexMesh mesh = test::distorted_mesh(ElementKind::Hex8, 0.0);  // 0..2, 0..3, 0..2
  EXPECT_NEAR(locate(mesh, {-0.5, 1.3, 1.0}).distance_m, 0.5, 1e-12);
  EXPECT_NEAR(locate(mesh, {5.0, 7.0, 1.0}).distance_m, 5.0, 1e-12);
  EXPECT_EQ(locate(mesh, {2.0, 3.0, 2.0}).distance_m, 0.0);
  const MeshPoint beside = locate(mesh, {2.5, 2.5, 1.5});
  EXPECT_LT((beside.xi - Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(mesh.nodes.col(mesh.elements(0, beside.element)), Vector3d(1, 2, 1));
}

TEST(Locate, AFlagBesideTheMeshMovesWithTheTurnOfItsFoot) {
  // A bent mesh: u_z = x², slope 2 x; the flag is glued at x = 2 and reaches to x = 3.
  const HexMesh mesh = test::distorted_mesh(ElementKind::Hex20, 0.0);
  VectorXd field = VectorXd::Zero(mesh.num_dofs());
  for (int n = 0; n < mesh.num_nodes(); ++n) field[3 * n + 2] = mesh.nodes(0, n) * mesh.nodes(0, n);
  EXPECT_NEAR(interpolate(locate(mesh, {3.0, 1.0, 1.0}), field).z(), 4.0 + 4.0 * 1.0, 1e-12);
}

TEST(Locate, RefusesAPointThatIsNowhere) {
  const HexMesh mesh = test::distorted_mesh(ElementKind::Hex8, 0.0);
  EXPECT_TRUE(test::holds(test::refusal_of([&] { (void)locate(mesh, {kNaN, 0, 0}); }), "nan"));
  EXPECT_TRUE(test::holds(test::refusal_of([] { (void)locate(HexMesh{}, {0, 0, 0}); }), "without"));
}

}  // namespace
}  // namespace twang
