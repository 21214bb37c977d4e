// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dense_algebra.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace twang {
namespace {

template <typename Solver>
SymmetricEigen pairs_of(const Solver& solver) {
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

template <typename Svd, typename Matrix>
std::optional<Svd> svd_of(const Matrix& A) {
  if (A.size() == 0 || !A.allFinite()) return std::nullopt;
  const Eigen::BDCSVD<Matrix> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
  if (svd.info() != Eigen::Success) return std::nullopt;
  return Svd{svd.matrixU(), svd.singularValues(), svd.matrixV()};
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

std::optional<RealSvd> thin_svd(const Eigen::MatrixXd& A) { return svd_of<RealSvd>(A); }

std::optional<ComplexSvd> thin_svd(const Eigen::MatrixXcd& A) { return svd_of<ComplexSvd>(A); }

std::optional<Eigenpairs> eigenpairs(const Eigen::MatrixXcd& A) {
  if (A.size() == 0 || !A.allFinite()) return std::nullopt;
  const Eigen::ComplexEigenSolver<Eigen::MatrixXcd> solver(A);
  if (solver.info() != Eigen::Success) return std::nullopt;
  return Eigenpairs{solver.eigenvalues(), solver.eigenvectors()};
}

std::optional<Eigen::VectorXcd> eigenvalues(const Eigen::MatrixXd& A) {
  if (A.size() == 0 || !A.allFinite()) return std::nullopt;
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(A, false);
  if (solver.info() != Eigen::Success) return std::nullopt;
  return solver.eigenvalues();
}

std::optional<Eigen::MatrixXd> solve(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  if (A.size() == 0) return std::nullopt;
  const Eigen::MatrixXd X = Eigen::PartialPivLU<Eigen::MatrixXd>(A).solve(B);
  if (!X.allFinite()) return std::nullopt;
  return X;
}

std::optional<Eigen::MatrixXd> cholesky(const Eigen::MatrixXd& A) {
  if (A.size() == 0 || !A.allFinite()) return std::nullopt;
  const Eigen::LLT<Eigen::MatrixXd, Eigen::Upper> llt(A);
  if (llt.info() != Eigen::Success) return std::nullopt;
  return Eigen::MatrixXd(llt.matrixU());
}

Eigen::MatrixXd solve_triangle(const Eigen::MatrixXd& R, const Eigen::MatrixXd& B) {
  return R.triangularView<Eigen::Upper>().solve(B);
}

Eigen::MatrixXd solve_transposed_triangle(const Eigen::MatrixXd& R, const Eigen::MatrixXd& B) {
  return R.transpose().triangularView<Eigen::Lower>().solve(B);
}

}  // namespace twang
