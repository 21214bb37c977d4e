// SPDX-License-Identifier: GPL-3.0-or-later
// Static problems with published answers, and CalculiX beside them where it is installed.
#include "core/constants.hpp"
#include "fem/constitutive.hpp"
#include "fem/elastic_body.hpp"
#include "fem/linear_solver.hpp"
#include "fem/mapped_block.hpp"
#include "tests/support/calculix.hpp"
#include "tests/support/rigs.hpp"
#include "tests/support/temporary_folder.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace twang {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// The nodal forces of a traction [Pa] on those faces of elements that lie in the block's plane
/// xi[axis] = 1 and whose corners all satisfy `is_loaded`.
template <typename IsLoaded, typename Traction>
VectorXd surface_load(const HexMesh& mesh, int axis, IsLoaded&& is_loaded, Traction&& traction) {
  VectorXd force = VectorXd::Zero(mesh.num_dofs());
  const double g = std::sqrt(0.6);  // three Gauss points a side
  const int second = (axis + 1) % 3;
  const int third = (axis + 2) % 3;
  for (int e = 0; e < mesh.num_elements(); ++e) {
    bool loaded = true;
    for (int a = 0; a < 8; ++a) {
      if (reference_node(a)[axis] > 0.0) {
        loaded = loaded && is_loaded(mesh.nodes.col(mesh.elements(a, e)));
      }
    }
    if (!loaded) continue;
    for (const double s : {-g, 0.0, g}) {
      for (const double t : {-g, 0.0, g}) {
        const double weight = (s == 0.0 ? 8.0 : 5.0) * (t == 0.0 ? 8.0 : 5.0) / 81.0;
        Vector3d xi = Vector3d::Ones();
        xi[second] = s;
        xi[third] = t;
        const VectorXd N = shape_functions(mesh.kind, xi);
        const Eigen::Matrix3Xd dN = shape_gradients(mesh.kind, xi);
        Eigen::Matrix3d x_by_xi = Eigen::Matrix3d::Zero();
        for (int a = 0; a < N.size(); ++a) {
          x_by_xi += mesh.nodes.col(mesh.elements(a, e)) * dN.col(a).transpose();
        }
        const Vector3d area = x_by_xi.col(second).cross(x_by_xi.col(third));
        for (int a = 0; a < N.size(); ++a) {
          force.segment<3>(3 * mesh.elements(a, e)) += weight * N[a] * traction(area);
        }
      }
    }
  }
  return force;
}

/// A linear elastic body, what holds it and what loads it.
struct Problem {
  HexMesh mesh;
  ElasticMaterial material;
  FreeDofs free;
  VectorXd force;

  [[nodiscard]] VectorXd solve() const {
    const ElasticBody body(mesh, {material}, ConstitutiveModel::Linear);
    const SparseMatrix K = free.restrict_matrix(body.stiffness({}));
    const auto solver = make_cholesky_solver();
    EXPECT_EQ(solver->analyze(K), SolveStatus::Ok);
    EXPECT_EQ(solver->factorize(K), SolveStatus::Ok);
    Eigen::MatrixXd u;
    EXPECT_EQ(solver->solve(free.restrict_vector(force), u), SolveStatus::Ok);
    return free.expand_vector(u);
  }
  [[nodiscard]] int node_at(const Vector3d& x) const {
    Eigen::Index node = 0;
    EXPECT_LT((mesh.nodes.colwise() - x).colwise().norm().minCoeff(&node), 1e-9);
    return static_cast<int>(node);
  }
};

/// NAFEMS LE10: a thick plate between two ellipses, a quarter of it, under pressure; `cells`
/// across, around and through it.
Problem thick_plate(std::array<int, 3> cells) {
  MappedBlock block;
  block.cells = cells;
  block.map = [](const Vector3d& s) {
    const double angle = 0.5 * kPi * s.y();
    const double a = 2.0 + 1.25 * s.x();
    const double b = 1.0 + 1.75 * s.x();
    return Vector3d(a * std::cos(angle), b * std::sin(angle), 0.6 * s.z());
  };
  const HexMesh mesh = mesh_block(block, ElementKind::Hex20);
  constexpr double kNear = 1e-9;
  std::vector<int> held;
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    const Vector3d x = mesh.nodes.col(n);
    const bool outer =
        std::abs(std::pow(x.x() / 3.25, 2) + std::pow(x.y() / 2.75, 2) - 1.0) < kNear;
    if (outer || x.x() < kNear) held.push_back(3 * n);
    if (outer || x.y() < kNear) held.push_back(3 * n + 1);
    if (outer && std::abs(x.z() - 0.3) < kNear) held.push_back(3 * n + 2);
  }
  const VectorXd pressure = surface_load(
      mesh,
      2,
      [](const Vector3d& x) { return x.z() > 0.6 - kNear; },
      [](const Vector3d& area) { return Vector3d(-1e6 * area); });
  return {mesh,
          test::elastic(210e9, 0.3, 7800.0),
          FreeDofs::from_held_dofs(mesh.num_nodes(), held),
          pressure};
}

const Vector3d kPointD(2.0, 0.0, 0.6);

/// sigma_yy at a node [Pa], by the mean over the elements there of E : grad u.
double stress_yy(const Problem& problem, const VectorXd& u, int node) {
  const HexMesh& mesh = problem.mesh;
  const LameConstants lame =
      lame_constants(problem.material.youngs_modulus_pa, problem.material.poissons_ratio);
  double sum = 0.0;
  int count = 0;
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (int a = 0; a < mesh.elements.rows(); ++a) {
      if (mesh.elements(a, e) != node) continue;
      const Eigen::Matrix3Xd dN = shape_gradients(mesh.kind, reference_node(a));
      Eigen::Matrix3d x_by_xi = Eigen::Matrix3d::Zero();
      Eigen::Matrix3d u_by_xi = Eigen::Matrix3d::Zero();
      for (int b = 0; b < mesh.elements.rows(); ++b) {
        const int other = mesh.elements(b, e);
        x_by_xi += mesh.nodes.col(other) * dN.col(b).transpose();
        u_by_xi += u.segment<3>(3 * other) * dN.col(b).transpose();
      }
      const Eigen::Matrix3d gradient = u_by_xi * x_by_xi.inverse();
      sum += 2.0 * lame.mu * gradient(1, 1) + lame.lambda * gradient.trace();
      ++count;
    }
  }
  return sum / count;
}

TEST(NafemsLe10, StressAtDIsThePrintedOne) {
  // printed: -5.38 MPa. 48 elements come within 2 %, eight times as many within 0.2 %: they all but
  // converge to it.
  const Problem coarse = thick_plate({6, 4, 2});
  EXPECT_NEAR(stress_yy(coarse, coarse.solve(), coarse.node_at(kPointD)) / -5.38e6, 1.0, 0.02);
  const Problem fine = thick_plate({12, 8, 4});
  EXPECT_NEAR(stress_yy(fine, fine.solve(), fine.node_at(kPointD)) / -5.38e6, 1.0, 2e-3);
}

TEST(NafemsLe10, DisplacementsEqualCalculix) {
  if (!test::has_calculix()) GTEST_SKIP() << "ccx (CalculiX) is not installed";
  const Problem plate = thick_plate({6, 4, 2});
  const VectorXd u = plate.solve();
  const test::TemporaryFolder folder;
  ASSERT_TRUE(test::run_calculix_job(
      test::calculix_static_deck(plate.mesh, {plate.material}, plate.free, plate.force),
      folder.path()));
  const VectorXd peer = test::calculix_displacements(folder / "job.dat", plate.mesh.num_nodes());
  // Seven digits are printed, of the largest displacement two or three fewer of small ones.
  EXPECT_LT((u - peer).cwiseAbs().maxCoeff(), 1e-6 * u.cwiseAbs().maxCoeff());
  // Its stresses are extrapolated from its integration points, ours are taken at the node.
  const double stress = test::calculix_stress(folder / "job.frd", plate.node_at(kPointD), 1);
  EXPECT_NEAR(stress / -5.38e6, 1.0, 0.02);
  EXPECT_NEAR(stress_yy(plate, u, plate.node_at(kPointD)) / stress, 1.0, 0.02);
}

/// Cook's membrane as a slab with free faces: its middle plane is at z = 0, half of it is meshed.
Problem cooks_membrane(ElementKind kind, int cells) {
  constexpr double kDepth = 1.0;
  MappedBlock block;
  block.cells = {cells, cells, 1};
  block.map = [](const Vector3d& s) {
    const double low = 44.0 * s.x();
    const double high = 44.0 + 16.0 * s.x();
    return Vector3d(48.0 * s.x(), low + (high - low) * s.y(), kDepth * s.z());
  };
  const HexMesh mesh = mesh_block(block, kind);
  std::vector<int> held;
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    const Vector3d x = mesh.nodes.col(n);
    if (x.x() < 1e-9) held.insert(held.end(), {3 * n, 3 * n + 1});
    if (std::abs(x.z()) < 1e-9) held.push_back(3 * n + 2);
  }
  // A shear of one over the right edge, 16 high.
  const VectorXd shear = surface_load(
      mesh,
      0,
      [](const Vector3d& x) { return x.x() > 48.0 - 1e-9; },
      [](const Vector3d& area) { return Vector3d(0.0, area.norm() / (16.0 * kDepth), 0.0); });
  return {mesh,
          test::elastic(1.0, 1.0 / 3.0, 1.0),
          FreeDofs::from_held_dofs(mesh.num_nodes(), held),
          shear};
}

double cooks_deflection(ElementKind kind, int cells) {
  const Problem membrane = cooks_membrane(kind, cells);
  const VectorXd u = membrane.solve();
  return u[3 * membrane.node_at({48.0, 52.0, 0.0}) + 1];
}

TEST(CooksMembrane, DeflectsAsPublishedByEveryElement) {
  // 23.96 in plane stress. Each element by as many cells a side as it needs for 0.5 %.
  EXPECT_NEAR(cooks_deflection(ElementKind::Hex20, 8) / 23.96, 1.0, 5e-3);
  EXPECT_NEAR(cooks_deflection(ElementKind::Hex8e, 16) / 23.96, 1.0, 5e-3);
  EXPECT_NEAR(cooks_deflection(ElementKind::Hex8, 64) / 23.96, 1.0, 5e-3);
  // Four cells a side are too stiff: by 1 %, 4 % and 26 %.
  EXPECT_LT(cooks_deflection(ElementKind::Hex8, 4) / 23.96, 0.76);
  EXPECT_GT(cooks_deflection(ElementKind::Hex8e, 4) / 23.96, 0.95);
  EXPECT_GT(cooks_deflection(ElementKind::Hex20, 4) / 23.96, 0.985);
}

}  // namespace
}  // namespace twang
