// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/detail/decompositions.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <limits>
#include <random>

namespace twang::detail {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;

/// Round-off of sums of a few dozen products.
constexpr double kRoundOff = 1e-13;

MatrixXcd random_matrix(Index rows, Index columns, std::uint32_t seed) {
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
    const MatrixXcd a = random_matrix(rows, columns, 1);
    const auto svd = thin_svd(a);
    ASSERT_TRUE(svd);
    EXPECT_EQ(svd->s.size(), std::min(rows, columns));
    EXPECT_LT((svd->u * svd->s.asDiagonal() * svd->v.adjoint() - a).norm(), kRoundOff * a.norm());
    EXPECT_LT(off_identity(svd->u), kRoundOff);
    EXPECT_LT(off_identity(svd->v), kRoundOff);
    for (Index i = 1; i < svd->s.size(); ++i) EXPECT_LE(svd->s(i), svd->s(i - 1));
    EXPECT_GE(svd->s(svd->s.size() - 1), 0.0);
  }
}

TEST(ComplexSvd, FindsTheSingularValuesThatWerePutIn) {
  // Over the twelve decades that tell rank from round-off, and none at all.
  const Index n = 20;
  Eigen::VectorXd s = Eigen::VectorXd::Zero(n);
  for (Index i = 0; i < 14; ++i) s(i) = std::pow(10.0, -static_cast<double>(i));
  const MatrixXcd u = thin_svd(random_matrix(n, n, 2))->u;
  const MatrixXcd v = thin_svd(random_matrix(n, n, 3))->u;
  const auto svd = thin_svd(MatrixXcd(u * s.asDiagonal() * v.adjoint()));
  ASSERT_TRUE(svd);
  // Absolute round-off of the largest, which is 1.
  EXPECT_LT((svd->s - s).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Eigenpairs, SolveTheirEquation) {
  for (const Index n : {1, 2, 3, 30}) {
    const MatrixXcd a = random_matrix(n, n, 4);
    const auto eigen = eigenpairs(a);
    ASSERT_TRUE(eigen);
    EXPECT_LT((a * eigen->vectors - eigen->vectors * eigen->values.asDiagonal()).norm(),
              kRoundOff * a.norm() * static_cast<double>(n));
    EXPECT_LT((eigen->vectors.colwise().norm().array() - 1.0).abs().maxCoeff(), kRoundOff);
    EXPECT_LT(std::abs(eigen->values.sum() - a.trace()), kRoundOff * a.norm());
  }
}

TEST(Eigenpairs, AreThoseThatWerePutIn) {
  const Index n = 12;
  VectorXcd values(n);
  for (Index i = 0; i < n; ++i)
    values(i) = std::polar(1.0 - 0.01 * static_cast<double>(i), 0.1 * static_cast<double>(i));
  const MatrixXcd q = thin_svd(random_matrix(n, n, 5))->u;
  const auto eigen = eigenpairs(q * values.asDiagonal() * q.adjoint());
  ASSERT_TRUE(eigen);
  for (const Complex value : values) {
    // A normal matrix has its eigenvalues to round-off.
    EXPECT_LT((eigen->values.array() - value).abs().minCoeff(), kRoundOff);
  }
}

TEST(Decompositions, HaveNoAnswerForWhatIsNotFinite) {
  MatrixXcd a = random_matrix(3, 3, 6);
  a(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(thin_svd(a));
  EXPECT_FALSE(eigenpairs(a));
  EXPECT_FALSE(thin_svd(MatrixXcd(0, 3)));
}

}  // namespace
}  // namespace twang::detail
