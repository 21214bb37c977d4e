// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/matrix_pencil.hpp"

#include "core/constants.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <complex>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Poles with positive frequency from the leading `order` right singular vectors.
std::vector<PoleCandidate> poles_of_subspace(const MatrixXd& v, Index order, double step_s) {
  const MatrixXd v1 = v.topRows(v.rows() - 1).leftCols(order);
  const MatrixXd v2 = v.bottomRows(v.rows() - 1).leftCols(order);
  // Total least squares: [V1 V2] = U S W^T, X = -W12 W22^-1.
  MatrixXd both(v1.rows(), 2 * order);
  both << v1, v2;
  const Eigen::JacobiSVD<MatrixXd, Eigen::HouseholderQRPreconditioner> svd(both,
                                                                           Eigen::ComputeThinV);
  std::vector<PoleCandidate> out;
  const MatrixXd& w = svd.matrixV();
  if (w.cols() < 2 * order) return out;
  const MatrixXd w12 = w.block(0, order, order, order);
  const MatrixXd w22 = w.block(order, order, order, order);
  const MatrixXd x = -w22.transpose().fullPivLu().solve(w12.transpose()).transpose();
  if (!x.allFinite()) return out;
  const Eigen::EigenSolver<MatrixXd> eigen(x, false);
  if (eigen.info() != Eigen::Success) return out;
  for (Index i = 0; i < order; ++i) {
    const std::complex<double> u = eigen.eigenvalues()(i);
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
  const Eigen::BDCSVD<MatrixXd> svd(hankel, Eigen::ComputeThinV);
  for (std::size_t i = 0; i < orders.size(); ++i) {
    const Index order = orders[i];
    if (order < 1 || 2 * order > pencil) continue;
    out[i] = poles_of_subspace(svd.matrixV(), order, signal.step_s);
  }
  return out;
}

std::vector<PoleCandidate> matrix_pencil(const EvenSeries& signal, int order) {
  return matrix_pencil(signal, std::vector<int>{order}).front();
}

}  // namespace twang
