// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dense_algebra.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <limits>
#include <random>

namespace twang {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

/// Round-off of sums of a few dozen products.
constexpr double kSvdRoundOff = 1e-13;

MatrixXcd random_complex_matrix(Index rows, Index columns, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  MatrixXcd a(rows, columns);
  for (Complex& value : a.reshaped()) value = Complex(normal(generator), normal(generator));
  return a;
}

double off_identity(const MatrixXcd& a) {
  return (a.adjoint() * a - MatrixXcd::Identity(a.cols(), a.cols())).norm();
}

TEST(ComplexSvd, IsTheMatrixWhateverItsShape) {
  for (const auto& [rows, columns] :
       {std::pair{1, 1}, {2, 2}, {30, 30}, {30, 7}, {7, 30}, {5, 1}}) {
    const MatrixXcd a = random_complex_matrix(rows, columns, 1);
    const auto svd = thin_svd(a);
    ASSERT_TRUE(svd);
    EXPECT_EQ(svd->s.size(), std::min(rows, columns));
    EXPECT_LT((svd->u * svd->s.asDiagonal() * svd->v.adjoint() - a).norm(),
              kSvdRoundOff * a.norm());
    EXPECT_LT(off_identity(svd->u), kSvdRoundOff);
    EXPECT_LT(off_identity(svd->v), kSvdRoundOff);
    for (Index i = 1; i < svd->s.size(); ++i) EXPECT_LE(svd->s(i), svd->s(i - 1));
    EXPECT_GE(svd->s(svd->s.size() - 1), 0.0);
  }
}

TEST(ComplexSvd, FindsTheSingularValuesThatWerePutIn) {
  // Over the twelve decades that tell rank from round-off, and none at all.
  const Index n = 20;
  Eigen::VectorXd s = Eigen::VectorXd::Zero(n);
  for (Index i = 0; i < 14; ++i) s(i) = std::pow(10.0, -static_cast<double>(i));
  const MatrixXcd u = thin_svd(random_complex_matrix(n, n, 2))->u;
  const MatrixXcd v = thin_svd(random_complex_matrix(n, n, 3))->u;
  const auto svd = thin_svd(MatrixXcd(u * s.asDiagonal() * v.adjoint()));
  ASSERT_TRUE(svd);
  // Absolute round-off of the largest, which is 1.
  EXPECT_LT((svd->s - s).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Eigenpairs, SolveTheirEquation) {
  for (const Index n : {1, 2, 3, 30}) {
    const MatrixXcd a = random_complex_matrix(n, n, 4);
    const auto eigen = eigenpairs(a);
    ASSERT_TRUE(eigen);
    EXPECT_LT((a * eigen->vectors - eigen->vectors * eigen->values.asDiagonal()).norm(),
              kSvdRoundOff * a.norm() * static_cast<double>(n));
    EXPECT_LT((eigen->vectors.colwise().norm().array() - 1.0).abs().maxCoeff(), kSvdRoundOff);
    EXPECT_LT(std::abs(eigen->values.sum() - a.trace()), kSvdRoundOff * a.norm());
  }
}

TEST(Eigenpairs, AreThoseThatWerePutIn) {
  const Index n = 12;
  VectorXcd values(n);
  for (Index i = 0; i < n; ++i)
    values(i) = std::polar(1.0 - 0.01 * static_cast<double>(i), 0.1 * static_cast<double>(i));
  const MatrixXcd q = thin_svd(random_complex_matrix(n, n, 5))->u;
  const auto eigen = eigenpairs(q * values.asDiagonal() * q.adjoint());
  ASSERT_TRUE(eigen);
  for (const Complex value : values) {
    // A normal matrix has its eigenvalues to round-off.
    EXPECT_LT((eigen->values.array() - value).abs().minCoeff(), kSvdRoundOff);
  }
}

MatrixXd random_real(Index rows, Index columns, std::uint32_t seed) {
  return random_complex_matrix(rows, columns, seed).real();
}

TEST(RealSolvers, SolveTheirEquations) {
  const MatrixXd a = random_real(9, 9, 7);
  const MatrixXd b = random_real(9, 3, 8);
  const auto x = solve(a, b);
  ASSERT_TRUE(x);
  // The condition of so small a random matrix is some tens.
  EXPECT_LT((a * *x - b).norm(), 1e-12);
  const MatrixXd tall = random_real(20, 6, 9);
  const MatrixXd normal = tall.transpose() * tall;
  const auto r = cholesky(normal);
  ASSERT_TRUE(r);
  EXPECT_LT((r->transpose() * *r - normal).norm(), kSvdRoundOff * normal.norm());
  EXPECT_TRUE(r->isUpperTriangular(0.0));
  const MatrixXd c = random_real(6, 2, 11);
  EXPECT_LT((*r * solve_triangle(*r, c) - c).norm(), 1e-12);
  EXPECT_LT((r->transpose() * solve_transposed_triangle(*r, c) - c).norm(), 1e-12);
}

TEST(RealSvd, IsTheMatrixWhateverItsShape) {
  for (const auto& [rows, columns] : {std::pair{1, 1}, {30, 30}, {80, 41}, {7, 30}, {5, 1}}) {
    const MatrixXd a = random_real(rows, columns, 13);
    const auto svd = thin_svd(a);
    ASSERT_TRUE(svd);
    EXPECT_EQ(svd->s.size(), std::min(rows, columns));
    EXPECT_LT((svd->u * svd->s.asDiagonal() * svd->v.transpose() - a).norm(),
              kSvdRoundOff * a.norm());
    EXPECT_LT(off_identity(svd->u), kSvdRoundOff);
    EXPECT_LT(off_identity(svd->v), kSvdRoundOff);
    EXPECT_GE(svd->s(svd->s.size() - 1), 0.0);
  }
}

TEST(Eigenvalues, OfARealMatrixAreTheRootsOfItsPolynomial) {
  // Companion of (x - 2) (x² - 2 x + 5) = x³ - 4 x² + 9 x - 10: 2 and 1 ± 2 i.
  MatrixXd a = MatrixXd::Zero(3, 3);
  a.row(0) << 4.0, -9.0, 10.0;
  a(1, 0) = a(2, 1) = 1.0;
  const auto values = eigenvalues(a);
  ASSERT_TRUE(values);
  for (const Complex root : {Complex(2.0, 0.0), Complex(1.0, 2.0), Complex(1.0, -2.0)})
    EXPECT_LT((values->array() - root).abs().minCoeff(), kSvdRoundOff);
  a(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(eigenvalues(a));
}

TEST(RealSolvers, HaveNoAnswerForWhatIsSingular) {
  MatrixXd a = random_real(4, 4, 12);
  a.col(2).setZero();
  EXPECT_FALSE(solve(a, a));
  EXPECT_FALSE(cholesky(MatrixXd(-MatrixXd::Identity(3, 3))));
}

TEST(Decompositions, HaveNoAnswerForWhatIsNotFinite) {
  MatrixXcd a = random_complex_matrix(3, 3, 6);
  a(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(thin_svd(a));
  EXPECT_FALSE(eigenpairs(a));
  EXPECT_FALSE(thin_svd(MatrixXcd(0, 3)));
}

}  // namespace
}  // namespace twang
