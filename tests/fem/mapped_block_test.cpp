// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/mapped_block.hpp"

#include "core/constants.hpp"
#include "fem/constitutive.hpp"
#include "fem/elastic_body.hpp"
#include "fem/linear_solver.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/rigs.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace twang {
namespace {

using Eigen::Vector3d;

/// A tube of radii 1 and 2 and of length 3.
MappedBlock tube(int around) {
  MappedBlock block;
  block.cells = {2, around, 2};
  block.map = [](const Vector3d& s) {
    const double angle = 2.0 * kPi * s.y();
    const double r = 1.0 + s.x();
    return Vector3d(r * std::cos(angle), r * std::sin(angle), 3.0 * s.z());
  };
  block.closed = {false, true, false};
  return block;
}

TEST(MappedBlock, ClosesARingAndApproachesItsVolume) {
  const double exact = 9.0 * kPi;
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    const HexMesh mesh = mesh_block(tube(24), kind);
    EXPECT_EQ(mesh.num_elements(), 96);
    const int corners = 3 * 24 * 3;
    const int edges = 2 * 24 * 3 + 3 * 24 * 3 + 3 * 24 * 2;
    EXPECT_EQ(mesh.num_nodes(), kind == ElementKind::Hex8 ? corners : corners + edges);
    // hex8: chords, sin(15 deg) / 15 deg in the area; hex20: parabolas, of order four.
    const double chords = std::sin(kPi / 12.0) / (kPi / 12.0);
    EXPECT_NEAR(mesh.volume() / exact, kind == ElementKind::Hex8 ? chords : 1.0, 1e-4);
    const double of_kind = kind == ElementKind::Hex8 ? mesh.volume() / (exact * chords) : 1.0;
    EXPECT_NEAR(of_kind, 1.0, 1e-12);
    EXPECT_EQ(surface_faces(mesh).size(), 2U * 24U * 2U + 2U * 24U * 2U);
  }
  const double coarse = mesh_block(tube(12), ElementKind::Hex20).volume() / exact - 1.0;
  const double fine = mesh_block(tube(24), ElementKind::Hex20).volume() / exact - 1.0;
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.1);
}

TEST(MappedBlock, RefusesWhatIsNoBlock) {
  const auto refusal = [](const MappedBlock& block) {
    return test::refusal_of([&] { (void)mesh_block(block, ElementKind::Hex8); });
  };
  MappedBlock block = tube(2);
  EXPECT_TRUE(test::holds(refusal(block), "2 cells along axis 1, must have 3"));
  block = tube(8);
  block.cells[0] = 0;
  EXPECT_TRUE(test::holds(refusal(block), "0 cells along axis 0"));
  block = tube(8);
  block.map = [](const Vector3d& s) { return Vector3d(s.y(), s.x(), s.z()); };
  block.closed = {};
  EXPECT_TRUE(test::holds(refusal(block), "inside out"));
  block.map = {};
  EXPECT_TRUE(test::holds(refusal(block), "no map"));
}

/// NAFEMS LE10: a thick plate between two ellipses, a quarter of it, under pressure.
class ThickPlate {
 public:
  explicit ThickPlate(std::array<int, 3> cells) {
    MappedBlock block;
    block.cells = cells;
    block.map = [](const Vector3d& s) {
      const double angle = 0.5 * kPi * s.y();
      const double a = 2.0 + 1.25 * s.x();
      const double b = 1.0 + 1.75 * s.x();
      return Vector3d(a * std::cos(angle), b * std::sin(angle), 0.6 * s.z());
    };
    m_mesh = mesh_block(block, ElementKind::Hex20);
  }

  /// sigma_yy at D = (2, 0, 0.6) [Pa], by the mean over the elements there of E : grad u.
  [[nodiscard]] double stress_at_d() const {
    const Eigen::VectorXd u = solve();
    double sum = 0.0;
    int count = 0;
    for (int e = 0; e < m_mesh.num_elements(); ++e) {
      for (int a = 0; a < 20; ++a) {
        if ((m_mesh.nodes.col(m_mesh.elements(a, e)) - Vector3d(2.0, 0.0, 0.6)).norm() > 1e-9) {
          continue;
        }
        const Eigen::Matrix3Xd dN = shape_gradients(m_mesh.kind, reference_node(a));
        Eigen::Matrix3d x_by_xi = Eigen::Matrix3d::Zero();
        Eigen::Matrix3d u_by_xi = Eigen::Matrix3d::Zero();
        for (int b = 0; b < 20; ++b) {
          const int node = m_mesh.elements(b, e);
          x_by_xi += m_mesh.nodes.col(node) * dN.col(b).transpose();
          u_by_xi += u.segment<3>(3 * node) * dN.col(b).transpose();
        }
        const Eigen::Matrix3d gradient = u_by_xi * x_by_xi.inverse();
        const LameConstants lame = lame_constants(210e9, 0.3);
        sum += 2.0 * lame.mu * gradient(1, 1) + lame.lambda * gradient.trace();
        ++count;
      }
    }
    EXPECT_GT(count, 0);
    return sum / count;
  }

 private:
  [[nodiscard]] std::vector<int> held_dofs() const {
    constexpr double kNear = 1e-9;
    std::vector<int> held;
    for (int n = 0; n < m_mesh.num_nodes(); ++n) {
      const Vector3d x = m_mesh.nodes.col(n);
      const bool outer =
          std::abs(std::pow(x.x() / 3.25, 2) + std::pow(x.y() / 2.75, 2) - 1.0) < kNear;
      if (outer || x.x() < kNear) held.push_back(3 * n);
      if (outer || x.y() < kNear) held.push_back(3 * n + 1);
      if (outer && std::abs(x.z() - 0.3) < kNear) held.push_back(3 * n + 2);
    }
    return held;
  }

  /// 1 MPa down on the upper face.
  [[nodiscard]] Eigen::VectorXd pressure() const {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(m_mesh.num_dofs());
    const double g = std::sqrt(0.6);
    for (int e = 0; e < m_mesh.num_elements(); ++e) {
      if (m_mesh.nodes(2, m_mesh.elements(4, e)) < 0.6 - 1e-9) continue;
      for (const double xi : {-g, 0.0, g}) {
        for (const double eta : {-g, 0.0, g}) {
          const double weight = (xi == 0.0 ? 8.0 : 5.0) * (eta == 0.0 ? 8.0 : 5.0) / 81.0;
          const Eigen::VectorXd N = shape_functions(m_mesh.kind, {xi, eta, 1.0});
          const Eigen::Matrix3Xd dN = shape_gradients(m_mesh.kind, {xi, eta, 1.0});
          Eigen::Matrix3d x_by_xi = Eigen::Matrix3d::Zero();
          for (int a = 0; a < 20; ++a) {
            x_by_xi += m_mesh.nodes.col(m_mesh.elements(a, e)) * dN.col(a).transpose();
          }
          const Vector3d area = x_by_xi.col(0).cross(x_by_xi.col(1));
          for (int a = 0; a < 20; ++a) {
            force.segment<3>(3 * m_mesh.elements(a, e)) -= 1e6 * weight * N[a] * area;
          }
        }
      }
    }
    return force;
  }

  [[nodiscard]] Eigen::VectorXd solve() const {
    const ElasticBody body(m_mesh, {test::elastic(210e9, 0.3, 7800.0)}, ConstitutiveModel::Linear);
    const FreeDofs free = FreeDofs::from_held_dofs(m_mesh.num_nodes(), held_dofs());
    const SparseMatrix K = free.restrict_matrix(body.stiffness({}));
    const auto solver = make_cholesky_solver();
    EXPECT_EQ(solver->analyze(K), SolveStatus::Ok);
    EXPECT_EQ(solver->factorize(K), SolveStatus::Ok);
    Eigen::MatrixXd u;
    EXPECT_EQ(solver->solve(free.restrict_vector(pressure()), u), SolveStatus::Ok);
    return free.expand_vector(u);
  }

  HexMesh m_mesh;
};

TEST(MappedBlock, CarriesTheThickPlateOfNafemsLe10) {
  // printed: -5.38 MPa; 2 % is the claim
  EXPECT_NEAR(ThickPlate({16, 8, 4}).stress_at_d() / -5.38e6, 1.0, 0.02);
}

}  // namespace
}  // namespace twang
