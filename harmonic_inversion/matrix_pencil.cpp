// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/matrix_pencil.hpp"

#include "core/constants.hpp"
#include "core/dense_algebra.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A fall by this factor from one singular value to the next parts a signal from round-off.
constexpr double kGreatFall = 1e4;
/// Singular values above this many times their median are no noise.
constexpr double kAboveMedian = 3.0;

/// How many singular values belong to the signal.
Index significant_order(const VectorXd& singular) {
  Index order = 0;
  double greatest = kGreatFall;
  for (Index i = 0; i + 1 < singular.size(); ++i) {
    const double fall = singular(i) / std::max(singular(i + 1), 1e-300);
    if (fall <= greatest) continue;
    greatest = fall;
    order = i + 1;
  }
  if (order > 0) return order;
  return (singular.array() > kAboveMedian * singular(singular.size() / 2)).count();
}

/// X of V2 = V1 X; nothing where there is none.
std::optional<MatrixXd> solve_shift(const MatrixXd& v1, const MatrixXd& v2) {
  const Index order = v1.cols();
  // So many poles leave no room for errors on both sides.
  if (2 * order > v1.rows()) return solve_least_squares(v1, v2).x;
  // Total least squares: [V1 V2] = U S W^T, X = -W12 W22^-1.
  MatrixXd both(v1.rows(), 2 * order);
  both << v1, v2;
  const auto svd = thin_svd(both);
  if (!svd) return std::nullopt;
  const MatrixXd& w = svd->v;
  const auto x = solve(w.block(order, order, order, order).transpose(),
                       w.block(0, order, order, order).transpose());
  if (!x) return std::nullopt;
  return MatrixXd(-x->transpose());
}

/// Poles with positive frequency from the leading `order` right singular vectors.
std::vector<PoleCandidate> poles_of_subspace(const MatrixXd& v, Index order, double step_s) {
  std::vector<PoleCandidate> out;
  const Index shifted = v.rows() - 1;
  const auto x =
      solve_shift(v.topRows(shifted).leftCols(order), v.bottomRows(shifted).leftCols(order));
  if (!x) return out;
  const auto values = eigenvalues(*x);
  if (!values) return out;
  for (Index i = 0; i < order; ++i) {
    const std::complex<double> u = (*values)(i);
    if (u.imag() <= 0.0 || !(std::abs(u) > 1e-6)) continue;
    const std::complex<double> log_u = std::log(u);
    out.push_back({{log_u.imag() / (kTwoPi * step_s), -log_u.real() / step_s}, 0.0, 0.0});
  }
  std::sort(out.begin(), out.end(), [](const PoleCandidate& a, const PoleCandidate& b) {
    return a.pole.decay_per_s < b.pole.decay_per_s;
  });
  return out;
}

}  // namespace

std::vector<std::vector<PoleCandidate>> matrix_pencil(const EvenSeries& signal,
                                                      const std::vector<int>& orders) {
  std::vector<std::vector<PoleCandidate>> out(orders.size());
  const Index n = signal.value.size();
  const Index pencil = n / 3;
  if (pencil < 3 || !signal.value.allFinite()) return out;
  MatrixXd hankel(n - pencil, pencil + 1);
  for (Index j = 0; j <= pencil; ++j) hankel.col(j) = signal.value.segment(j, n - pencil);
  const auto svd = thin_svd(hankel);
  if (!svd) return out;
  for (std::size_t i = 0; i < orders.size(); ++i) {
    const Index order = orders[i] > 0 ? orders[i] : significant_order(svd->s);
    if (order < 1 || order >= pencil) continue;
    out[i] = poles_of_subspace(svd->v, order, signal.step_s);
  }
  return out;
}

std::vector<PoleCandidate> matrix_pencil(const EvenSeries& signal, int order) {
  return matrix_pencil(signal, std::vector<int>{order}).front();
}

}  // namespace twang
