// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/lobpcg.hpp"

#include "core/dense_algebra.hpp"
#include "fem/detail/thread_limits.hpp"

#include <cblas.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Directions of the scaled basis below this part of its largest are dropped as round-off.
constexpr double kDependent = 1e-11;
/// Columns whose products with M are held at a time.
constexpr Index kColumnsAtOnce = 8;
/// Rows that stay in the cache while the basis is recombined.
constexpr Index kRowsAtOnce = 512;

/// A' B of tall matrices.
MatrixXd gram(const Eigen::Ref<const MatrixXd>& A, const Eigen::Ref<const MatrixXd>& B) {
  MatrixXd result = MatrixXd::Zero(A.cols(), B.cols());
  if (result.size() == 0) return result;
  cblas_dgemm(CblasColMajor,
              CblasTrans,
              CblasNoTrans,
              static_cast<int>(A.cols()),
              static_cast<int>(B.cols()),
              static_cast<int>(A.rows()),
              1.0,
              A.data(),
              static_cast<int>(A.outerStride()),
              B.data(),
              static_cast<int>(B.outerStride()),
              0.0,
              result.data(),
              static_cast<int>(result.rows()));
  return result;
}

/// Y += factor A C.
void add_product(double factor,
                 const Eigen::Ref<const MatrixXd>& A,
                 const MatrixXd& C,
                 Eigen::Ref<MatrixXd> Y) {
  if (C.size() == 0) return;
  cblas_dgemm(CblasColMajor,
              CblasNoTrans,
              CblasNoTrans,
              static_cast<int>(A.rows()),
              static_cast<int>(C.cols()),
              static_cast<int>(A.cols()),
              factor,
              A.data(),
              static_cast<int>(A.outerStride()),
              C.data(),
              static_cast<int>(C.rows()),
              1.0,
              Y.data(),
              static_cast<int>(Y.outerStride()));
}

/// The first columns of S become S C, in place.
void recombine(MatrixXd& S, const MatrixXd& C) {
  MatrixXd rows(kRowsAtOnce, C.cols());
  for (Index first = 0; first < S.rows(); first += kRowsAtOnce) {
    const Index count = std::min(kRowsAtOnce, S.rows() - first);
    rows.setZero();
    add_product(1.0, S.block(first, 0, count, C.rows()), C, rows.topRows(count));
    S.block(first, 0, count, C.cols()) = rows.topRows(count);
  }
}

/// Coefficients of the Ritz vectors in a basis, mass-orthonormal, and the Ritz values, ascending.
struct Ritz {
  VectorXd values;
  MatrixXd coefficients;
  bool good = false;
};

/// Of a basis that may be dependent: scaled to unit length, directions of round-off left out.
Ritz rayleigh_ritz(const MatrixXd& K, const MatrixXd& M) {
  Ritz ritz;
  const VectorXd length = M.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (!(length.minCoeff() > 0.0) || !M.allFinite() || !K.allFinite()) return ritz;
  const VectorXd scale = length.cwiseInverse();
  const SymmetricEigen lengths = symmetric_eigen(scale.asDiagonal() * M * scale.asDiagonal());
  const double largest = lengths.values[lengths.values.size() - 1];
  const Index dropped = (lengths.values.array() <= kDependent * largest).count();
  const Index kept = lengths.values.size() - dropped;
  const MatrixXd T = scale.asDiagonal() * lengths.vectors.rightCols(kept) *
                     lengths.values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  MatrixXd H = T.transpose() * K * T;
  H = (0.5 * (H + H.transpose())).eval();
  const SymmetricEigen eigen = symmetric_eigen(H);
  ritz.values = eigen.values;
  ritz.coefficients = T * eigen.vectors;
  ritz.good = lengths.converged && eigen.converged && ritz.values.allFinite();
  return ritz;
}

/// The basis [X P W] and K times it.
class BlockIteration {
 public:
  BlockIteration(const PreconditionedProblem& problem, MatrixXd start, const LobpcgOptions& options)
      : m_problem(problem), m_options(options), m_block(start.cols()) {
    m_S.resize(start.rows(), 3 * m_block);
    m_KS.resize(start.rows(), 3 * m_block);
    m_S.leftCols(m_block) = start;
    if (problem.known.cols() > 0) {
      m_known_mass.resize(problem.known.rows(), problem.known.cols());
      for (Index k = 0; k < problem.known.cols(); ++k) {
        m_known_mass.col(k) = problem.apply_mass(problem.known.col(k));
      }
    }
  }

  /// Makes the start its own Ritz vectors; false if it does not span enough.
  bool begin() {
    remove_known(m_S.leftCols(m_block));
    apply_stiffness(0, m_block);
    const Ritz ritz = rayleigh_ritz(stiffness_gram(m_block), mass_gram(m_block));
    if (!ritz.good || ritz.values.size() < m_options.count) return false;
    m_block = ritz.values.size();
    recombine(m_S, ritz.coefficients);
    recombine(m_KS, ritz.coefficients);
    m_lambda = ritz.values;
    m_last_active.clear();
    return true;
  }

  /// Preconditioned residuals of all that have not converged; true if none is left.
  bool residuals() {
    std::vector<Index> active;
    const Index first = m_block + num_changes();
    Index next = first;
    m_worst = 0.0;
    for (Index k = 0; k < m_block; ++k) {
      const VectorXd r = m_KS.col(k) - m_lambda[k] * m_problem.apply_mass(m_S.col(k));
      const VectorXd w = m_problem.precondition(r);
      const double error = std::abs(r.dot(w) / m_lambda[k]);
      const bool wanted = k < m_options.count;
      if (wanted) m_worst = std::max(m_worst, std::isfinite(error) ? error : 1.0);
      if (error <= (wanted ? m_options.tolerance : m_options.guard_tolerance)) continue;
      active.push_back(k);
      m_S.col(next++) = w;
    }
    keep_changes(active, next - first);
    return active.empty();
  }

  /// One step of Rayleigh-Ritz; false if it breaks down.
  bool step() {
    const Index num_active = static_cast<Index>(m_last_active.size());
    const Index first = m_block + m_num_kept;
    const Index size = first + num_active;
    auto W = m_S.middleCols(first, num_active);
    remove_known(W);
    for (Index k = 0; k < num_active; ++k) {
      const VectorXd mass = m_problem.apply_mass(W.col(k));
      const double length = std::sqrt(W.col(k).dot(mass));
      if (!(length > 0.0)) return false;
      const MatrixXd along = gram(m_S.leftCols(m_block), mass) / length;
      W.col(k) /= length;
      add_product(-1.0, m_S.leftCols(m_block), along, W.middleCols(k, 1));
    }
    apply_stiffness(first, num_active);
    const Ritz ritz = rayleigh_ritz(stiffness_gram(size), mass_gram(size));
    if (!ritz.good || ritz.values.size() < m_block) return false;
    MatrixXd C(size, m_block + num_active);
    C.leftCols(m_block) = ritz.coefficients.leftCols(m_block);
    for (Index k = 0; k < num_active; ++k) {
      C.col(m_block + k) = C.col(m_last_active[static_cast<std::size_t>(k)]);
    }
    C.topRightCorner(m_block, num_active).setZero();
    recombine(m_S, C);
    recombine(m_KS, C);
    m_lambda = ritz.values.head(m_block);
    m_num_kept = num_active;
    return true;
  }

  [[nodiscard]] double worst() const { return m_worst; }
  [[nodiscard]] LobpcgResult result() const {
    LobpcgResult result;
    result.lambda = m_lambda.head(m_options.count);
    result.vectors = m_S.leftCols(m_options.count);
    result.worst_error = m_worst;
    return result;
  }

 private:
  [[nodiscard]] Index num_changes() const { return m_num_kept; }

  /// Of the last changes, which stand before the new residuals, only those of active vectors.
  void keep_changes(const std::vector<Index>& active, Index num_residuals) {
    Index kept = 0;
    for (std::size_t i = 0; i < m_last_active.size() && m_num_kept > 0; ++i) {
      if (std::find(active.begin(), active.end(), m_last_active[i]) == active.end()) continue;
      const Index from = m_block + static_cast<Index>(i);
      if (m_block + kept != from) {
        m_S.col(m_block + kept) = m_S.col(from);
        m_KS.col(m_block + kept) = m_KS.col(from);
      }
      ++kept;
    }
    if (kept != m_num_kept) {
      for (Index k = 0; k < num_residuals; ++k) {
        m_S.col(m_block + kept + k) = m_S.col(m_block + m_num_kept + k);
      }
    }
    m_num_kept = kept;
    m_last_active = active;
  }

  void remove_known(Eigen::Ref<MatrixXd> V) {
    if (m_known_mass.cols() == 0) return;
    add_product(-1.0, m_problem.known, gram(m_known_mass, V), V);
  }

  void apply_stiffness(Index first, Index count) {
    for (Index k = first; k < first + count; ++k) {
      m_KS.col(k) = m_problem.apply_stiffness(m_S.col(k));
    }
  }

  [[nodiscard]] MatrixXd stiffness_gram(Index size) const {
    const MatrixXd K = gram(m_S.leftCols(size), m_KS.leftCols(size));
    return 0.5 * (K + K.transpose());
  }

  [[nodiscard]] MatrixXd mass_gram(Index size) const {
    MatrixXd M(size, size);
    MatrixXd products(m_S.rows(), std::min(kColumnsAtOnce, size));
    for (Index first = 0; first < size; first += kColumnsAtOnce) {
      const Index count = std::min(kColumnsAtOnce, size - first);
      for (Index k = 0; k < count; ++k) {
        products.col(k) = m_problem.apply_mass(m_S.col(first + k));
      }
      M.middleCols(first, count) = gram(m_S.leftCols(size), products.leftCols(count));
    }
    return 0.5 * (M + M.transpose());
  }

  const PreconditionedProblem& m_problem;
  const LobpcgOptions& m_options;
  Index m_block;
  Index m_num_kept = 0;  ///< last changes in the basis
  MatrixXd m_S, m_KS;
  MatrixXd m_known_mass;
  VectorXd m_lambda;
  std::vector<Index> m_last_active;  ///< vectors that the residuals, then the changes belong to
  double m_worst = 0.0;
};

}  // namespace

LobpcgResult find_smallest_preconditioned(const PreconditionedProblem& problem,
                                          MatrixXd start,
                                          const LobpcgOptions& options) {
  LobpcgResult failure;
  failure.termination = Termination::NumericalFailure;
  failure.message = "the start of the block iteration does not span enough";
  BlockIteration iteration(problem, std::move(start), options);
  if (!iteration.begin()) return failure;
  bool converged = false;
  int count = 0;
  while (true) {
    const PoliteThreads threads;
    const ThreadLimits limits(machine_is_busy());
    converged = iteration.residuals();
    if (options.progress) options.progress(count, iteration.worst());
    if (converged || count == options.max_iterations) break;
    if (!iteration.step()) {
      failure.message = "the block iteration broke down: its basis became dependent";
      return failure;
    }
    ++count;
  }
  LobpcgResult result = iteration.result();
  result.iterations = count;
  result.termination = converged ? Termination::Converged : Termination::IterationLimit;
  result.message = fmt::format("{} modes in {} block iterations", options.count, count);
  if (!converged) {
    result.message = fmt::format(
        "after {} block iterations the eigenvalues are estimated to err by up to {:.2g}, must be "
        "<= {:.2g}",
        count,
        result.worst_error,
        options.tolerance);
  }
  return result;
}

}  // namespace twang
