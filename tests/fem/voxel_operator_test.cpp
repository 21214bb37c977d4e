// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/coarse_grid.hpp"
#include "fem/detail/grid_problem.hpp"
#include "fem/detail/voxel_body.hpp"
#include "tests/fem/distorted_mesh.hpp"
#include "tests/support/finite_differences.hpp"
#include "tests/support/rigs.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::random_vector;

Rig step_rig() {
  return test::make_rig({test::box_mm({0, 0, 0}, {13, 4, 2}), test::box_mm({9, 1, 2}, {13, 4, 7})},
                        {test::box_mm({0, 0, 0}, {0, 4, 2})});
}

/// A step of two materials in cells whose sides differ.
struct Bodies {
  HexMesh mesh;
  ElasticBody body;
  FreeDofs free;
};
Bodies two_materials(ElementKind kind = ElementKind::Hex8) {
  const double dx_m = 1e-3;
  Rig rig = step_rig();
  rig.materials.push_back(rig.materials.front());
  rig.materials.back().name = "other";
  rig.parts[1].material = "other";
  HexMesh mesh = mesh_part(rig, dx_m, kind);
  for (int axis = 0; axis < 3; ++axis) mesh.nodes.row(axis) *= 1.0 + 0.3 * axis;
  // Cells that are full in part, and weigh what lies beside them too.
  mesh.stiffness_fill = test::random_vector(mesh.num_elements(), 0.3, 7).array() + 0.6;
  mesh.mass_fill = test::random_vector(mesh.num_elements(), 0.4, 8).array() + 0.9;
  ElasticMaterial soft = test::elastic(1e9, 0.45, 1205);
  ElasticMaterial stiff = test::elastic(7e10, 0.2, 2700);
  soft.damping_stiffness_b_s = 2e-4;
  stiff.damping_stiffness_b_s = 1e-5;
  std::vector<int> held = clamped_nodes(mesh_part(rig, dx_m, kind), rig);
  std::vector<int> dofs;
  for (const int node : held) dofs.insert(dofs.end(), {3 * node, 3 * node + 1, 3 * node + 2});
  dofs.push_back(3 * (mesh.num_nodes() - 1) + 1);  // a roller
  FreeDofs free = FreeDofs::from_held_dofs(mesh.num_nodes(), dofs);
  return {mesh, ElasticBody(mesh, {soft, stiff}), std::move(free)};
}

SparseMatrix assembled(const Bodies& at, const StiffnessCombination& of) {
  SparseMatrix A =
      of.stiffness * at.body.stiffness({}) + of.damping * at.body.stiffness_damping({});
  A += of.mass * at.body.mass();
  return at.free.restrict_matrix(A);
}

class GridProblemOf : public ::testing::TestWithParam<ElementKind> {};
INSTANTIATE_TEST_SUITE_P(Elements,
                         GridProblemOf,
                         ::testing::Values(ElementKind::Hex8,
                                           ElementKind::Hex8e,
                                           ElementKind::Hex20),
                         [](const auto& at) { return std::string(to_string(at.param)); });

TEST_P(GridProblemOf, EqualsTheAssembledMatrix) {
  Bodies at = two_materials(GetParam());
  at.body.add_point_mass(locate(at.mesh, at.mesh.nodes.rowwise().maxCoeff()), 0.1);
  const VectorXd x = random_vector(at.free.size(), 1.0, 3);
  const auto problem = make_grid_problem(at.body, at.free, 100);
  for (const StiffnessCombination& of : {StiffnessCombination{1.0, 0.0, 0.0},
                                         StiffnessCombination{0.0, 0.0, 1.0},
                                         StiffnessCombination{2.0, 1e3, 1e7},
                                         StiffnessCombination{0.0, 1e3, 0.0}}) {
    const LinearMap product = problem->matrix(of, {});
    const VectorXd own = problem->to_free(product(problem->from_free(x)));
    const VectorXd expected = assembled(at, of) * x;
    EXPECT_LT((own - expected).norm(), 1e-13 * expected.norm());  // round-off
    const VectorXd full = problem->to_full(product(problem->from_full(at.free.expand_vector(x))));
    EXPECT_EQ((full - at.free.expand_vector(own)).norm(), 0.0);
  }
}

TEST_P(GridProblemOf, CyclesSymmetricallyAndPositivelyDefinite) {
  const Bodies at = two_materials(GetParam());
  const auto problem = make_grid_problem(at.body, at.free, 100);
  ASSERT_EQ(problem->prepare({1.0, 0.0, 1e6}), SolveStatus::Ok);
  const auto start = [&](unsigned seed) {
    return problem->from_free(random_vector(at.free.size(), 1.0, seed));
  };
  for (unsigned seed = 1; seed < 6; ++seed) {
    const VectorXd a = start(seed);
    const VectorXd b = start(seed + 10);
    const VectorXd cycled = problem->cycle(a);
    // Single precision, of a result that may be much smaller than its factors.
    EXPECT_NEAR(b.dot(cycled), a.dot(problem->cycle(b)), 1e-5 * b.norm() * cycled.norm());
    EXPECT_GT(a.dot(cycled), 0.0);
    for (int i = 0; i < problem->size(); ++i) {
      if (problem->held()[static_cast<std::size_t>(i)] == 0) continue;
      EXPECT_EQ(cycled[i], 0.0);
    }
  }
}

TEST_P(GridProblemOf, TakesTheStiffnessWhereTheBodyIs) {
  const Bodies at = two_materials(GetParam());
  const VectorXd u = random_vector(at.mesh.num_dofs(), 1e-4, 5);
  const VectorXd x = random_vector(at.free.size(), 1.0, 3);
  const auto problem = make_grid_problem(at.body, at.free, 100);
  const LinearMap product = problem->matrix({1.0, 2.0, 3.0}, u);
  SparseMatrix A = at.body.stiffness(u) + 2.0 * at.body.stiffness_damping(u);
  A += 3.0 * at.body.mass();
  const VectorXd expected = at.free.restrict_matrix(A) * x;
  const VectorXd own = problem->to_free(product(problem->from_free(x)));
  EXPECT_LT((own - expected).norm(), 1e-12 * expected.norm());  // round-off
  const LinearMap undeformed = problem->matrix({1.0, 2.0, 3.0}, {});
  const VectorXd other = problem->to_free(undeformed(problem->from_free(x)));
  EXPECT_GT((other - expected).norm(), 1e-3 * expected.norm());
}

TEST(VoxelOperator, IsTheSameInSinglePrecisionAndOnEveryInstructionSet) {
  const int length = 21;  // two vectors of floats and a rest
  const int nodes = 4 * (length + 1);
  const VectorXd x = random_vector(3 * nodes, 1.0, 1);
  const VectorXd mu = random_vector(length, 0.5, 2).array() + 1.0;
  const VectorXd lambda = random_vector(length, 0.5, 3).array() + 2.0;
  const VectorXd mass = random_vector(length, 0.5, 4).array() + 1.0;
  const auto run = [&]<class Real>(const VoxelKernels& kernels, bool enhanced, Real) {
    using Values = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
    const Values from = x.cast<Real>(), m = mu.cast<Real>(), l = lambda.cast<Real>(),
                 d = mass.cast<Real>();
    Values to = Values::Zero(3 * nodes);
    CellRow<Real> row;
    row.length = length;
    for (int a = 0; a < 3; ++a) {
      for (int edge = 0; edge < 4; ++edge) {
        row.x[a][edge] = from.data() + a * nodes + edge * (length + 1);
        row.y[a][edge] = to.data() + a * nodes + edge * (length + 1);
      }
    }
    row.mu = m.data();
    row.lambda = l.data();
    row.mass = d.data();
    const CellConstants<Real> constants{{Real(2.0), Real(1.0), Real(1.5)}, Real(-0.5)};
    kernels.products<Real>(enhanced).both(constants, row);
    return VectorXd(to.template cast<double>());
  };
  for (const bool enhanced : {false, true}) {
    const VectorXd baseline = run(voxel_baseline::kernels(), enhanced, 0.0);
    EXPECT_GT(baseline.norm(), 1.0);
    // Single precision.
    EXPECT_LT((run(voxel_baseline::kernels(), enhanced, 0.0F) - baseline).norm(),
              1e-6 * baseline.norm());
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) continue;
    // Fused multiply-adds round differently.
    EXPECT_LT((run(voxel_x86_64_v3::kernels(), enhanced, 0.0) - baseline).norm(),
              1e-14 * baseline.norm());
    EXPECT_LT((run(voxel_x86_64_v3::kernels(), enhanced, 0.0F) - baseline).norm(),
              1e-6 * baseline.norm());
  }
}

TEST(VoxelOperator, NamesWhatIsNoGrid) {
  EXPECT_EQ(voxel_fault(mesh_part(step_rig(), 1e-3, ElementKind::Hex8)), "");
  HexMesh quadratic = mesh_part(step_rig(), 1e-3, ElementKind::Hex20);
  EXPECT_NE(voxel_fault(quadratic), "");
  EXPECT_EQ(grid_fault(quadratic), "");
  quadratic.nodes(1, quadratic.elements(13, 4)) += 1e-5;
  EXPECT_EQ(grid_fault(quadratic), "its edges are curved");
  EXPECT_NE(grid_fault(test::distorted_mesh(ElementKind::Hex20, 1e-3)), "");
  EXPECT_NE(voxel_fault(test::distorted_mesh(ElementKind::Hex8, 1e-3)), "");
  HexMesh split = mesh_part(step_rig(), 1e-3, ElementKind::Hex8);
  split.nodes.conservativeResize(3, split.nodes.cols() + 1);
  split.nodes.rightCols<1>() = split.nodes.col(split.elements(6, 5));
  split.elements(6, 5) = split.num_nodes() - 1;  // a crack
  EXPECT_NE(voxel_fault(split), "");
}

/// Values of `coarse` on the finer grid, in double precision.
MatrixXd dense_interpolation(const CoarseGrid& coarse, const TypedGrid& fine) {
  const int columns = 3 * coarse.cells.grid.num_nodes();
  MatrixXd P(3 * fine.grid.num_nodes(), columns);
  Eigen::VectorXf column(P.rows());
  for (int j = 0; j < columns; ++j) {
    if (coarse.cells.held[static_cast<std::size_t>(j)] != 0) {
      P.col(j).setZero();
      continue;
    }
    const Eigen::VectorXf unit = Eigen::VectorXf::Unit(columns, j);
    coarse.prolong(fine, unit.data(), column.data());
    P.col(j) = column.cast<double>();
  }
  return P;
}

MatrixXd dense_matrix(const TypedGrid& cells, const std::vector<MatrixXd>& of_type) {
  const int num_nodes = cells.grid.num_nodes();
  const auto nodes = cells.grid.nodes_of_cells();
  MatrixXd A = MatrixXd::Zero(3 * num_nodes, 3 * num_nodes);
  for (int c = 0; c < cells.grid.num_cells(); ++c) {
    for (int i = 0; i < 24; ++i) {
      for (int j = 0; j < 24; ++j) {
        A(i / 8 * num_nodes + nodes(i % 8, c), j / 8 * num_nodes + nodes(j % 8, c)) +=
            of_type[static_cast<std::size_t>(cells.type[c])](i, j);
      }
    }
  }
  return A;
}

/// 5 x 3 x 4 cells with a hole, every other one of another type, three degrees of freedom held.
TypedGrid odd_grid() {
  std::vector<int> places;
  for (int i = 0; i < 60; ++i) {
    const int x = i % 5, y = i / 5 % 3, z = i / 15;
    if (x == 2 && z > 1) continue;
    places.insert(places.end(), {x, y, z});
  }
  TypedGrid fine;
  fine.grid = CellGrid(
      Eigen::Map<Eigen::Matrix3Xi>(places.data(), 3, static_cast<Eigen::Index>(places.size() / 3)));
  fine.held.assign(static_cast<std::size_t>(3 * fine.grid.num_nodes()), 0);
  for (const std::size_t dof : {0U, 7U, 100U}) fine.held[dof] = 1;
  fine.type.resize(fine.grid.num_cells());
  const auto nodes = fine.grid.nodes_of_cells();
  for (int c = 0; c < fine.grid.num_cells(); ++c) {
    fine.type[c] = c;
    fine.held_of_type.push_back(held_mask(fine.held, fine.grid.num_nodes(), nodes.col(c)));
  }
  fine.num_types = fine.grid.num_cells();
  return fine;
}

TEST(CoarseGrid, OperatorIsGalerkinsOnTwoLevels) {
  const TypedGrid fine = odd_grid();
  std::vector<MatrixXd> matrices;
  for (int c = 0; c < fine.num_types; ++c) {
    MatrixXd matrix = random_vector(576, 1.0, 10 + static_cast<unsigned>(c)).reshaped(24, 24);
    matrix = (matrix + matrix.transpose()).eval();
    for (int i = 0; i < 24; ++i) {
      if ((fine.held_of_type[static_cast<std::size_t>(c)] >> i & 1U) == 0) continue;
      matrix.row(i).setZero();
      matrix.col(i).setZero();
    }
    matrices.push_back(matrix);
  }
  const CoarseGrid coarse(fine);
  const CoarseGrid coarser(coarse.cells);
  EXPECT_LT(coarse.cells.grid.num_cells(), 22);
  EXPECT_LT(coarser.cells.grid.num_cells(), 7);
  const MatrixXd A = dense_matrix(fine, matrices);
  const MatrixXd P = dense_interpolation(coarse, fine);
  const std::vector<MatrixXd> first = coarse.matrices(matrices);
  // Weights are powers of 1/2: nothing but the round-off of sums.
  EXPECT_LT((dense_matrix(coarse.cells, first) - P.transpose() * A * P).norm(), 1e-13 * A.norm());
  const MatrixXd Q = P * dense_interpolation(coarser, coarse.cells);
  EXPECT_LT((dense_matrix(coarser.cells, coarser.matrices(first)) - Q.transpose() * A * Q).norm(),
            1e-13 * A.norm());
  EXPECT_GT(Q.norm(), 1.0);
}

TEST(CoarseGrid, RestrictionIsTheTransposeOfProlongation) {
  const TypedGrid fine = odd_grid();
  const CoarseGrid coarse(fine);
  const MatrixXd P = dense_interpolation(coarse, fine);
  VectorXd r = random_vector(static_cast<int>(P.rows()), 1.0, 4);
  for (std::size_t i = 0; i < fine.held.size(); ++i) {
    if (fine.held[i] != 0) r[static_cast<Eigen::Index>(i)] = 0.0;
  }
  const Eigen::VectorXf single = r.cast<float>();
  Eigen::VectorXf restricted(P.cols());
  coarse.restrict_to_coarse(fine, single.data(), restricted.data());
  // Single precision.
  EXPECT_LT((restricted.cast<double>() - P.transpose() * r).norm(), 1e-6 * r.norm());
}

}  // namespace
}  // namespace twang
