// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dense_algebra.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace twang {
namespace {

template <typename Solver>
SymmetricEigen pairs_of(const Solver& solver) {
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

}  // namespace

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A) {
  return pairs_of(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A));
}

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  return pairs_of(Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(A, B));
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b) {
  return Eigen::LDLT<Eigen::MatrixXd>(A).solve(b);
}

LeastSquares solve_least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  return {qr.solve(b), qr.rank()};
}

Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& A) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(A).householderQ() *
         Eigen::MatrixXd::Identity(A.rows(), A.cols());
}

Eigen::MatrixXd orthonormalized(const Eigen::MatrixXd& A, const Eigen::MatrixXd& gram) {
  return Eigen::LLT<Eigen::MatrixXd>(gram).matrixU().solve<Eigen::OnTheRight>(A);
}

}  // namespace twang
