// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/projected_fit.hpp"

#include "core/constants.hpp"
#include "core/dense_algebra.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Samples of one block: B and D of some tens of columns stay in the second-level cache.
constexpr Index kBlock = 256;
/// Samples between exact evaluations of a sinusoid; round-off grows by one unit a sample.
constexpr Index kRestart = 32;
/// Stamps off the even grid by less than this part of the time are on it: their own round-off.
constexpr double kEvenPart = 4.0 * std::numeric_limits<double>::epsilon();
/// A trifle of the diagonal that makes a singular normal matrix regular.
constexpr double kRidge = 1e-14;

std::complex<double> sinusoid_at(const DampedPole& pole, double time_s) {
  return std::polar(std::exp(std::min(-pole.decay_per_s * time_s, kMaxGrowthExponent)),
                    kTwoPi * pole.frequency_hz * time_s);
}

/// Cosine and sine of one pole; runs of even stamps by recurrence, u^(n+1) = u^n u.
void fill_sinusoid(const DampedPole& pole,
                   const Eigen::Ref<const VectorXd>& time_s,
                   Eigen::Ref<MatrixXd> out) {
  const Index n = time_s.size();
  for (Index first = 0; first < n; first += kRestart) {
    const Index last = std::min(first + kRestart, n) - 1;
    // The step of a run is taken over its length: the round-off of two late stamps is no step.
    const double step =
        (time_s(last) - time_s(first)) / static_cast<double>(std::max<Index>(last - first, 1));
    const std::complex<double> factor = sinusoid_at(pole, step);
    std::complex<double> value = sinusoid_at(pole, time_s(first));
    bool even = true;  // so far: a sample off the grid is no start for the next
    for (Index i = first; i <= last; ++i) {
      const double expected = time_s(first) + static_cast<double>(i - first) * step;
      if (i > first) {
        even = even && std::abs(time_s(i) - expected) <= kEvenPart * expected;
        value = even ? value * factor : sinusoid_at(pole, time_s(i));
      }
      out(i, 0) = value.real();
      out(i, 1) = value.imag();
    }
  }
}

/// The rows of one block of a channel.
class Block {
 public:
  Block(const SampleSeries& series, const VectorXd& weights, Index first, bool fit_drift)
      : m_count(std::min(kBlock, series.value.size() - first)),
        m_fit_drift(fit_drift),
        m_duration(duration_of(series)),
        m_time(series.time_s.segment(first, m_count)),
        m_value(series.value.segment(first, m_count)) {
    if (weights.size() > 0) m_weight = weights.segment(first, m_count);
  }

  /// B, unweighted.
  [[nodiscard]] MatrixXd basis(const std::vector<DampedPole>& poles) const {
    MatrixXd out(m_count, column_of_pole(m_fit_drift, poles.size()));
    out.col(0).setOnes();
    if (m_fit_drift) out.col(1) = m_time / m_duration;
    for (std::size_t k = 0; k < poles.size(); ++k) {
      fill_sinusoid(poles[k], m_time, out.middleCols(column_of_pole(m_fit_drift, k), 2));
    }
    return out;
  }

  [[nodiscard]] MatrixXd weighted_basis(const std::vector<DampedPole>& poles) const {
    MatrixXd out = basis(poles);
    if (m_weight.size() > 0) out.array().colwise() *= m_weight.array();
    return out;
  }

  [[nodiscard]] VectorXd weighted_value() const {
    return m_weight.size() > 0 ? VectorXd(m_weight.cwiseProduct(m_value)) : VectorXd(m_value);
  }

  /// D from the weighted basis.
  [[nodiscard]] MatrixXd derivatives(const MatrixXd& basis, const VectorXd& x) const {
    const Index first = column_of_pole(m_fit_drift, 0);
    MatrixXd out(basis.rows(), basis.cols() - first);
    for (Index j = 0; j < out.cols(); j += 2) {
      const auto cosine = basis.col(first + j).array();
      const auto sine = basis.col(first + j + 1).array();
      const double a = x(first + j);
      const double b = x(first + j + 1);
      out.col(j) = kTwoPi * m_time.array() * (b * cosine - a * sine);
      out.col(j + 1) = -m_time.array() * (a * cosine + b * sine);
    }
    return out;
  }

 private:
  Index m_count;
  bool m_fit_drift;
  double m_duration;
  VectorXd m_time;
  VectorXd m_value;
  VectorXd m_weight;
};

VectorXd solve_normal(const MatrixXd& r, const VectorXd& right) {
  return solve_triangle(r, solve_transposed_triangle(r, right));
}

}  // namespace

Index column_of_pole(bool fit_drift, std::size_t k) {
  return (fit_drift ? 2 : 1) + 2 * static_cast<Index>(k);
}

double duration_of(const SampleSeries& series) {
  const VectorXd& t = series.time_s;
  return std::max(t(t.size() - 1) - t(0), 1e-300);
}

MatrixXd regular_triangle(const MatrixXd& normal) {
  const VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const VectorXd inverse = scale.cwiseInverse();
  MatrixXd scaled = inverse.asDiagonal() * normal * inverse.asDiagonal();
  for (double ridge = 0.0; ridge < 1.0; ridge = std::max(10.0 * ridge, kRidge)) {
    scaled.diagonal().array() += ridge;
    if (const auto triangle = cholesky(scaled)) return *triangle * scale.asDiagonal();
  }
  return scale.asDiagonal();  // not finite: the caller sees it in the sum of squares
}

ProjectedFit fit_projected(const SampleSeries& series,
                           const VectorXd& weights,
                           const std::vector<DampedPole>& poles,
                           bool fit_drift,
                           bool with_derivatives) {
  const Index columns = column_of_pole(fit_drift, poles.size());
  const Index parameters = 2 * static_cast<Index>(poles.size());
  const Index n = series.value.size();

  MatrixXd gram = MatrixXd::Zero(columns, columns);
  VectorXd right = VectorXd::Zero(columns);
  for (Index first = 0; first < n; first += kBlock) {
    const Block block(series, weights, first, fit_drift);
    const MatrixXd b = block.weighted_basis(poles);
    gram.selfadjointView<Eigen::Lower>().rankUpdate(b.transpose());
    right += b.transpose() * block.weighted_value();
  }
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  ProjectedFit out;
  out.triangle = regular_triangle(gram);
  out.coefficients = solve_normal(out.triangle, right);

  // The residual itself, not its square by subtraction; what it still has in the span of B corrects
  // the coefficients, which makes up for the squared condition of the normal matrix.
  VectorXd leftover = VectorXd::Zero(columns);
  MatrixXd basis_by_d = MatrixXd::Zero(columns, parameters);
  MatrixXd d_by_d = MatrixXd::Zero(parameters, parameters);
  VectorXd d_by_r = VectorXd::Zero(parameters);
  for (Index first = 0; first < n; first += kBlock) {
    const Block block(series, weights, first, fit_drift);
    const MatrixXd b = block.weighted_basis(poles);
    const VectorXd r = block.weighted_value() - b * out.coefficients;
    out.sum_of_squares += r.squaredNorm();
    leftover += b.transpose() * r;
    if (!with_derivatives) continue;
    const MatrixXd d = block.derivatives(b, out.coefficients);
    basis_by_d.noalias() += b.transpose() * d;
    d_by_d.selfadjointView<Eigen::Lower>().rankUpdate(d.transpose());
    d_by_r += d.transpose() * r;
  }
  const VectorXd correction = solve_normal(out.triangle, leftover);
  out.coefficients += correction;
  out.sum_of_squares = std::max(out.sum_of_squares - leftover.dot(correction), 0.0);
  if (with_derivatives) {
    d_by_d.triangularView<Eigen::StrictlyUpper>() = d_by_d.transpose();
    out.inside = solve_transposed_triangle(out.triangle, basis_by_d);
    out.normal = d_by_d - out.inside.transpose() * out.inside;
    out.gradient = basis_by_d.transpose() * correction - d_by_r;
  }
  return out;
}

VectorXd evaluate_model(const SampleSeries& series,
                        const std::vector<DampedPole>& poles,
                        bool fit_drift,
                        const VectorXd& coefficients) {
  VectorXd out(series.value.size());
  for (Index first = 0; first < out.size(); first += kBlock) {
    const Block block(series, {}, first, fit_drift);
    const MatrixXd b = block.basis(poles);
    out.segment(first, b.rows()) = b * coefficients;
  }
  return out;
}

}  // namespace twang
