// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/detail/decompositions.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>
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
void dgesv_(const int* n,
            const int* nrhs,
            double* a,
            const int* lda,
            int* pivots,
            double* b,
            const int* ldb,
            int* info);
void dgels_(const char* trans,
            const int* m,
            const int* n,
            const int* nrhs,
            double* a,
            const int* lda,
            double* b,
            const int* ldb,
            double* work,
            const int* lwork,
            int* info);
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dtrtrs_(const char* uplo,
             const char* trans,
             const char* diag,
             const int* n,
             const int* nrhs,
             const double* a,
             const int* lda,
             double* b,
             const int* ldb,
             int* info);
}

namespace twang::detail {
namespace {

using Complex = std::complex<double>;
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

/// Reflects x, from its first entry on, to a real multiple of the first unit vector:
///
///     (I - tau v v^H)^H x = beta e_1,   v_1 = 1
///
/// x keeps v but for its first entry, which becomes beta.
Complex reflect(Eigen::Ref<VectorXcd> x) {
  const Complex alpha = x(0);
  const double rest = x.tail(x.size() - 1).squaredNorm();
  if (rest == 0.0 && alpha.imag() == 0.0) return 0.0;
  const double beta = std::copysign(std::sqrt(std::norm(alpha) + rest), -alpha.real());
  x.tail(x.size() - 1) /= alpha - beta;
  x(0) = beta;
  return {(beta - alpha.real()) / beta, -alpha.imag() / beta};
}

/// (I - tau v v^H) a, with the v that reflect() leaves.
void apply(Complex tau, const VectorXcd& kept, Eigen::Ref<MatrixXcd> a) {
  VectorXcd v = kept;
  v(0) = 1.0;
  for (Index j = 0; j < a.cols(); ++j) a.col(j) -= tau * v.dot(a.col(j)) * v;
}

/// a (I - tau v v^H), likewise.
void apply_from_right(Complex tau, const VectorXcd& kept, Eigen::Ref<MatrixXcd> a) {
  VectorXcd v = kept;
  v(0) = 1.0;
  const VectorXcd times = tau * (a * v);
  for (Index j = 0; j < a.cols(); ++j) a.col(j) -= std::conj(v(j)) * times;
}

/// A = Q B P^H with a real upper bidiagonal B, by Householder's reflections from both sides.
class Bidiagonal {
 public:
  /// @param a  of at least as many rows as columns
  explicit Bidiagonal(MatrixXcd a) : m_a(std::move(a)), m_right(m_a.cols(), m_a.cols()) {
    const Index n = m_a.cols();
    m_b = MatrixXd::Zero(n, n);
    for (Index k = 0; k < n; ++k) {
      const Index rows = m_a.rows() - k;
      m_tau_left.push_back(reflect(m_a.col(k).tail(rows)));
      m_b(k, k) = m_a(k, k).real();
      const Index columns = n - k - 1;
      if (columns == 0) break;
      apply(std::conj(m_tau_left.back()),
            m_a.col(k).tail(rows),
            m_a.bottomRightCorner(rows, columns));
      VectorXcd row = m_a.row(k).tail(columns).adjoint();
      m_tau_right.push_back(reflect(row));
      m_b(k, k + 1) = row(0).real();
      m_right.col(k).tail(columns) = row;
      apply_from_right(m_tau_right.back(), row, m_a.bottomRightCorner(rows - 1, columns));
    }
  }

  [[nodiscard]] const MatrixXd& dense() const { return m_b; }
  /// Q x and P x; Q has as many columns as A.
  [[nodiscard]] MatrixXcd left_times(const MatrixXd& x) const {
    MatrixXcd out = MatrixXcd::Zero(m_a.rows(), x.cols());
    out.topRows(x.rows()) = x.cast<Complex>();
    for (auto k = static_cast<Index>(m_tau_left.size()) - 1; k >= 0; --k) {
      const Index rows = m_a.rows() - k;
      apply(m_tau_left[static_cast<std::size_t>(k)], m_a.col(k).tail(rows), out.bottomRows(rows));
    }
    return out;
  }
  [[nodiscard]] MatrixXcd right_times(const MatrixXd& x) const {
    MatrixXcd out = x.cast<Complex>();
    for (auto k = static_cast<Index>(m_tau_right.size()) - 1; k >= 0; --k) {
      const Index rows = m_a.cols() - k - 1;
      apply(m_tau_right[static_cast<std::size_t>(k)],
            m_right.col(k).tail(rows),
            out.bottomRows(rows));
    }
    return out;
  }

 private:
  MatrixXcd m_a;      // below and on the diagonal the left vectors
  MatrixXcd m_right;  // column k the k-th right vector, below the diagonal
  MatrixXd m_b;
  std::vector<Complex> m_tau_left;
  std::vector<Complex> m_tau_right;
};

/// A = Q H Q^H, H zero below its subdiagonal.
struct Hessenberg {
  MatrixXcd h;
  MatrixXcd q;
};

Hessenberg reduce(const MatrixXcd& a) {
  const Index n = a.rows();
  Hessenberg out{a, MatrixXcd::Identity(n, n)};
  for (Index k = 0; k + 2 < n; ++k) {
    const Index rest = n - k - 1;
    VectorXcd v = out.h.col(k).tail(rest);
    const Complex tau = reflect(v);
    out.h.col(k).tail(rest).setZero();
    out.h(k + 1, k) = v(0);
    apply(std::conj(tau), v, out.h.bottomRightCorner(rest, rest));
    apply_from_right(tau, v, out.h.rightCols(rest));
    apply_from_right(tau, v, out.q.rightCols(rest));
  }
  return out;
}

/// x of T x = T_kk x, T upper triangular: k + 1 entries, the last of them 1.
VectorXcd eigenvector_of_triangle(const MatrixXcd& t, Index k) {
  VectorXcd x = -t.col(k).head(k + 1);
  x(k) = 1.0;
  const double least = std::numeric_limits<double>::epsilon() * t.norm();
  for (Index i = k - 1; i >= 0; --i) {
    Complex apart = t(i, i) - t(k, k);
    if (std::abs(apart) == 0.0) apart = least;
    x(i) /= apart;
    x.head(i) -= x(i) * t.col(i).head(i);
  }
  return x;
}

}  // namespace

// No complex routine of LAPACK: they go through OpenBLAS' zgemv, whose AVX-512 kernel (0.3.21)
// reads beyond the matrix.

std::optional<ComplexSvd> thin_svd(const MatrixXcd& a) {
  if (a.size() == 0 || !a.allFinite()) return std::nullopt;
  if (a.rows() < a.cols()) {
    auto turned = thin_svd(MatrixXcd(a.adjoint()));
    if (turned) std::swap(turned->u, turned->v);
    return turned;
  }
  const Bidiagonal reduced(a);
  const auto svd = thin_svd(reduced.dense());
  if (!svd) return std::nullopt;
  return ComplexSvd{reduced.left_times(svd->u), svd->s, reduced.right_times(svd->v)};
}

std::optional<Eigenpairs> eigenpairs(const MatrixXcd& a) {
  if (a.size() == 0 || !a.allFinite()) return std::nullopt;
  const Hessenberg reduced = reduce(a);
  Eigen::ComplexSchur<MatrixXcd> schur(a.rows());
  schur.computeFromHessenberg(reduced.h, reduced.q, true);
  if (schur.info() != Eigen::Success) return std::nullopt;
  const MatrixXcd& t = schur.matrixT();
  Eigenpairs out{t.diagonal(), MatrixXcd(a.rows(), a.rows())};
  for (Index k = 0; k < a.rows(); ++k) {
    const VectorXcd x = eigenvector_of_triangle(t, k);
    out.vectors.col(k) = schur.matrixU().leftCols(k + 1) * x;
    out.vectors.col(k) /= out.vectors.col(k).norm();
  }
  return out;
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

std::optional<MatrixXd> solve(MatrixXd a, MatrixXd b) {
  const int n = static_cast<int>(a.rows());
  const int columns = static_cast<int>(b.cols());
  if (n == 0 || !a.allFinite() || !b.allFinite()) return std::nullopt;
  std::vector<int> pivots(static_cast<std::size_t>(n));
  int info = 0;
  dgesv_(&n, &columns, a.data(), &n, pivots.data(), b.data(), &n, &info);
  if (info != 0) return std::nullopt;
  return b;
}

std::optional<MatrixXd> solve_least_squares(MatrixXd a, MatrixXd b) {
  const int m = static_cast<int>(a.rows());
  const int n = static_cast<int>(a.cols());
  const int columns = static_cast<int>(b.cols());
  if (n == 0 || m < n || !a.allFinite() || !b.allFinite()) return std::nullopt;
  const bool done = run_with_work_space<double>([&](double* work, const int* size, int* info) {
    dgels_("N", &m, &n, &columns, a.data(), &m, b.data(), &m, work, size, info);
  });
  if (!done) return std::nullopt;
  return MatrixXd(b.topRows(n));
}

std::optional<MatrixXd> cholesky(MatrixXd a) {
  const int n = static_cast<int>(a.rows());
  if (n == 0 || !a.allFinite()) return std::nullopt;
  int info = 0;
  dpotrf_("U", &n, a.data(), &n, &info);
  if (info != 0) return std::nullopt;
  for (Index j = 0; j < n; ++j) a.col(j).tail(n - j - 1).setZero();
  return a;
}

namespace {

MatrixXd solve_with(const char* transposed, const MatrixXd& r, MatrixXd b) {
  const int n = static_cast<int>(r.rows());
  const int columns = static_cast<int>(b.cols());
  if (n == 0 || columns == 0) return b;
  int info = 0;
  dtrtrs_("U", transposed, "N", &n, &columns, r.data(), &n, b.data(), &n, &info);
  return b;
}

}  // namespace

MatrixXd solve_triangle(const MatrixXd& r, MatrixXd b) { return solve_with("N", r, std::move(b)); }

MatrixXd solve_transposed_triangle(const MatrixXd& r, MatrixXd b) {
  return solve_with("T", r, std::move(b));
}

}  // namespace twang::detail
