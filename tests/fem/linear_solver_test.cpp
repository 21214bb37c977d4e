// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/linear_solver.hpp"

#include "fem/detail/cholesky_solver.hpp"
#include "tests/fem/distorted_mesh.hpp"
#include "tests/support/finite_differences.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace twang {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A stiffness with some nodes and one single direction held, so that not all columns come in
/// threes.
SparseMatrix some_stiffness() {
  const ElasticBody body(test::distorted_mesh(ElementKind::Hex20, 0.1),
                         {test::elastic(3.0, 0.3, 1.0)});
  const FreeDofs free =
      FreeDofs::from_held_dofs(body.mesh().num_nodes(), {0, 1, 2, 4, 9, 10, 11, 30, 31, 32, 50});
  return free.restrict_matrix(body.stiffness({}));
}

using Maker = std::unique_ptr<LinearSolver> (*)();
class EachCholesky : public ::testing::TestWithParam<Maker> {};
INSTANTIATE_TEST_SUITE_P(LinearSolver,
                         EachCholesky,
                         ::testing::Values(&make_cholesky_solver,
                                           &make_narrow_cholesky_solver,
                                           &make_wide_cholesky_solver));

TEST_P(EachCholesky, SolvesForSeveralRightHandSides) {
  const SparseMatrix A = some_stiffness();
  const auto solver = GetParam()();
  ASSERT_EQ(solver->analyze(A), SolveStatus::Ok);
  ASSERT_EQ(solver->factorize(A), SolveStatus::Ok);
  const MatrixXd X = test::random_vector(A.rows() * 3, 1.0, 8).reshaped(A.rows(), 3);
  MatrixXd solution;
  ASSERT_EQ(solver->solve(A * X, solution), SolveStatus::Ok);
  // Condition 1e4 times round-off, with room.
  EXPECT_LT((solution - X).norm(), 1e-10 * X.norm());
}

TEST_P(EachCholesky, SolvesRoughlyWithTheFactorOfTheMoment) {
  const SparseMatrix A = some_stiffness();
  const auto solver = GetParam()();
  ASSERT_EQ(solver->analyze(A), SolveStatus::Ok);
  VectorXd rough;
  const VectorXd b = test::random_vector(A.rows(), 1.0, 9);
  EXPECT_EQ(solver->solve_roughly(b, rough), SolveStatus::NotFactorized);
  for (const double scale : {1.0, 4.0}) {
    ASSERT_EQ(solver->factorize(SparseMatrix(scale * A)), SolveStatus::Ok);
    MatrixXd exact;
    ASSERT_EQ(solver->solve(b, exact), SolveStatus::Ok);
    ASSERT_EQ(solver->solve_roughly(b, rough), SolveStatus::Ok);
    // condition 1e4 times single precision, with room
    EXPECT_LT((rough - exact.col(0)).norm(), 3e-4 * exact.norm());
    // as well for loads that single precision could not hold, and for none
    VectorXd tiny;
    ASSERT_EQ(solver->solve_roughly(1e-60 * b, tiny), SolveStatus::Ok);
    EXPECT_LT((1e60 * tiny - rough).norm(), 1e-5 * rough.norm());
    ASSERT_EQ(solver->solve_roughly(0.0 * b, tiny), SolveStatus::Ok);
    EXPECT_EQ(tiny.norm(), 0.0);
  }
  EXPECT_EQ(solver->solve_roughly(b.head(5), rough), SolveStatus::Failed);
}

TEST_P(EachCholesky, KeepsTheAnalysisForOtherValues) {
  const SparseMatrix A = some_stiffness();
  const auto solver = GetParam()();
  ASSERT_EQ(solver->analyze(A), SolveStatus::Ok);
  const VectorXd b = VectorXd::Ones(A.rows());
  MatrixXd first;
  MatrixXd second;
  ASSERT_EQ(solver->factorize(A), SolveStatus::Ok);
  ASSERT_EQ(solver->solve(b, first), SolveStatus::Ok);
  ASSERT_EQ(solver->factorize(SparseMatrix(4.0 * A)), SolveStatus::Ok);
  ASSERT_EQ(solver->solve(b, second), SolveStatus::Ok);
  EXPECT_LT((first - 4.0 * second).norm(), 1e-13 * first.norm());
}

TEST_P(EachCholesky, SaysWhatIsWrong) {
  const SparseMatrix A = some_stiffness();
  const auto solver = GetParam()();
  MatrixXd X;
  EXPECT_EQ(solver->solve(VectorXd::Ones(A.rows()), X), SolveStatus::NotFactorized);
  EXPECT_NE(solver->factorize(A), SolveStatus::Ok) << "nothing was analysed";
  ASSERT_EQ(solver->analyze(A), SolveStatus::Ok);
  EXPECT_EQ(solver->factorize(SparseMatrix(-A)), SolveStatus::NotPositiveDefinite);
  EXPECT_EQ(solver->solve(VectorXd::Ones(A.rows()), X), SolveStatus::NotFactorized);
  ASSERT_EQ(solver->factorize(A), SolveStatus::Ok);
  EXPECT_EQ(solver->solve(VectorXd::Ones(A.rows() + 1), X), SolveStatus::Failed);
  EXPECT_EQ(solver->factorize(SparseMatrix(A.topLeftCorner(9, 9))), SolveStatus::Failed);
  EXPECT_EQ(solver->analyze(SparseMatrix(3, 4)), SolveStatus::Failed);
}

TEST_P(EachCholesky, ReadsOneTriangleAlone) {
  const SparseMatrix A = some_stiffness();
  SparseMatrix spoiled = A;
  for (int j = 0; j < A.cols(); ++j) {
    for (SparseMatrix::InnerIterator entry(spoiled, j); entry; ++entry) {
      if (entry.row() > j) entry.valueRef() = std::numeric_limits<double>::quiet_NaN();
    }
  }
  const auto solver = GetParam()();
  ASSERT_EQ(solver->analyze(spoiled), SolveStatus::Ok);
  ASSERT_EQ(solver->factorize(spoiled), SolveStatus::Ok);
  MatrixXd X;
  ASSERT_EQ(solver->solve(VectorXd::Ones(A.rows()), X), SolveStatus::Ok);
  EXPECT_LT((A * X - VectorXd::Ones(A.rows())).norm(), 1e-10);  // as above
}

TEST_P(EachCholesky, SolvesOneUnknown) {
  SparseMatrix A(1, 1);
  A.insert(0, 0) = 4.0;
  A.makeCompressed();
  const auto solver = GetParam()();
  ASSERT_EQ(solver->analyze(A), SolveStatus::Ok);
  ASSERT_EQ(solver->factorize(A), SolveStatus::Ok);
  MatrixXd X;
  ASSERT_EQ(solver->solve(VectorXd::Ones(1), X), SolveStatus::Ok);
  EXPECT_EQ(X(0, 0), 0.25);
}

}  // namespace
}  // namespace twang
