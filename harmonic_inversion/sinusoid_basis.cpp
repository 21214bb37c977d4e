// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/sinusoid_basis.hpp"

#include "core/constants.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <complex>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Samples between exact evaluations; round-off grows by one unit a sample.
constexpr Index kRestart = 32;
/// Stamps off the even grid by less than this part of a step are on it: 1e-12 of a period or less.
constexpr double kEvenStep = 1e-12;
/// Cholesky's factor squares the condition: pivots below this part of the column's norm are lost.
constexpr double kMinPivot = 1e-6;

std::complex<double> sinusoid_at(const DampedPole& pole, double time_s) {
  return std::polar(std::exp(std::min(-pole.decay_per_s * time_s, kMaxGrowthExponent)),
                    kTwoPi * pole.frequency_hz * time_s);
}

/// R of the Cholesky factorization of a^T a; false if a pivot is lost.
bool cholesky_factor(const MatrixXd& a, MatrixXd& r) {
  MatrixXd normal = MatrixXd::Zero(a.cols(), a.cols());
  normal.selfadjointView<Eigen::Lower>().rankUpdate(a.transpose());
  const Eigen::LLT<MatrixXd, Eigen::Lower> llt(normal);
  if (llt.info() != Eigen::Success) return false;
  r = llt.matrixU();
  for (Index i = 0; i < r.cols(); ++i) {
    if (!(r(i, i) > kMinPivot * std::sqrt(normal(i, i)))) return false;
  }
  return true;
}

}  // namespace

void fill_sinusoid_columns(const DampedPole& pole,
                           const Eigen::VectorXd& time_s,
                           Eigen::Ref<MatrixXd> out) {
  const Index n = time_s.size();
  const double step = n > 1 ? time_s(1) - time_s(0) : 0.0;
  const std::complex<double> factor = sinusoid_at(pole, step);
  std::complex<double> value;
  for (Index i = 0; i < n; ++i) {
    const Index since = i % kRestart;
    const double expected = time_s(i - since) + static_cast<double>(since) * step;
    if (since != 0 && std::abs(time_s(i) - expected) <= kEvenStep * step) {
      value *= factor;
    } else {
      value = sinusoid_at(pole, time_s(i));
    }
    out(i, 0) = value.real();
    out(i, 1) = value.imag();
  }
}

void orthonormalize(const MatrixXd& a, MatrixXd& q, MatrixXd& r) {
  MatrixXd first;
  MatrixXd second;
  if (a.rows() >= a.cols() && cholesky_factor(a, first)) {
    q = first.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(a);
    if (cholesky_factor(q, second)) {
      second.triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(q);
      r = second.triangularView<Eigen::Upper>() * first;
      return;
    }
  }
  const Eigen::HouseholderQR<MatrixXd> qr(a);
  q = qr.householderQ() * MatrixXd::Identity(a.rows(), a.cols());
  r = qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>();
}

}  // namespace twang
