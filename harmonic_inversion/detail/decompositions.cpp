// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/detail/decompositions.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

// The Fortran interface, which every LAPACK has.
extern "C" {
void dgesdd_(const char* job,
             const int* m,
             const int* n,
             double* a,
             const int* lda,
             double* s,
             double* u,
             const int* ldu,
             double* vt,
             const int* ldvt,
             double* work,
             const int* lwork,
             int* iwork,
             int* info);
void dgeev_(const char* jobvl,
            const char* jobvr,
            const int* n,
            double* a,
            const int* lda,
            double* wr,
            double* wi,
            double* vl,
            const int* ldvl,
            double* vr,
            const int* ldvr,
            double* work,
            const int* lwork,
            int* info);
}

namespace twang::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr int kAskForSize = -1;

/// Calls a LAPACK routine twice: for the size of its work space, and to work.
template <typename Scalar, typename Call>
bool run_with_work_space(const Call& call) {
  int info = 0;
  Scalar size{};
  call(&size, &kAskForSize, &info);
  const int length = info == 0 ? std::max(1, static_cast<int>(std::real(size))) : 1;
  std::vector<Scalar> work(static_cast<std::size_t>(length));
  if (info == 0) call(work.data(), &length, &info);
  return info == 0;
}

}  // namespace

// Complex ones by Eigen: LAPACK's go through OpenBLAS' zgemv, whose AVX-512 kernel (0.3.21) reads
// beyond the matrix.

std::optional<ComplexSvd> thin_svd(const MatrixXcd& a) {
  if (a.size() == 0 || !a.allFinite()) return std::nullopt;
  const Eigen::BDCSVD<MatrixXcd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return ComplexSvd{svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

std::optional<Eigenpairs> eigenpairs(const MatrixXcd& a) {
  if (a.size() == 0 || !a.allFinite()) return std::nullopt;
  const Eigen::ComplexEigenSolver<MatrixXcd> eigen(a);
  if (eigen.info() != Eigen::Success) return std::nullopt;
  return Eigenpairs{eigen.eigenvalues(), eigen.eigenvectors()};
}

std::optional<RealSvd> thin_svd(MatrixXd a) {
  const int m = static_cast<int>(a.rows());
  const int n = static_cast<int>(a.cols());
  const int least = std::min(m, n);
  if (least == 0 || !a.allFinite()) return std::nullopt;
  RealSvd out{MatrixXd(m, least), VectorXd(least), {}};
  MatrixXd vt(least, n);
  std::vector<int> whole_work(8 * static_cast<std::size_t>(least));
  const bool done = run_with_work_space<double>([&](double* work, const int* size, int* info) {
    dgesdd_("S",
            &m,
            &n,
            a.data(),
            &m,
            out.s.data(),
            out.u.data(),
            &m,
            vt.data(),
            &least,
            work,
            size,
            whole_work.data(),
            info);
  });
  if (!done) return std::nullopt;
  out.v = vt.transpose();
  return out;
}

std::optional<VectorXcd> eigenvalues(MatrixXd a) {
  const int n = static_cast<int>(a.rows());
  if (n == 0 || !a.allFinite()) return std::nullopt;
  VectorXd real(n);
  VectorXd imaginary(n);
  const bool done = run_with_work_space<double>([&](double* work, const int* size, int* info) {
    dgeev_("N",
           "N",
           &n,
           a.data(),
           &n,
           real.data(),
           imaginary.data(),
           nullptr,
           &n,
           nullptr,
           &n,
           work,
           size,
           info);
  });
  if (!done) return std::nullopt;
  VectorXcd out(n);
  out.real() = real;
  out.imag() = imaginary;
  return out;
}

}  // namespace twang::detail
