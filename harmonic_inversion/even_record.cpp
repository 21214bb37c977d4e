// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/even_record.hpp"

#include "core/constants.hpp"
#include "core/dense_algebra.hpp"
#include "harmonic_inversion/geometric_series.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace twang {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Below so many samples the plain way is as fast.
constexpr Index kLongRecord = 4096;
/// Samples of a block, and blocks that are worked on together.
constexpr Index kBlock = 128;
constexpr Index kBlocksTogether = 64;
/// Stamps may be off the grid by this part of a step: a phase error of 3e-6 at Nyquist ...
constexpr double kOffGrid = 1e-6;
/// ... which is nothing beside a residual above this part of the signal's energy.
constexpr double kLeastResidual = 1e-8;
/// More samples than this part without weight are left to the plain way.
constexpr double kMaxExcludedPart = 1e-3;
/// Moments stand for the samples where the residual is above this part of the signal's energy, and
/// where no more digits than these cancel between overlapping sinusoids.
constexpr double kLeastZoomedResidual = 1e-7;
constexpr double kMaxCancelling = 1e4;
/// The largest exponent of a growing pole.
constexpr double kMaxExponent = 100.0;

Complex exponent_of(const DampedPole& pole) {
  return {-pole.decay_per_s, kTwoPi * pole.frequency_hz};
}

VectorXd solve_normal(const MatrixXd& r, const VectorXd& right) {
  return solve_triangle(r, solve_transposed_triangle(r, right));
}

}  // namespace

/// Values of damped sinusoids within a block, and their factors from block to block.
class EvenRecord::Sinusoids {
 public:
  Sinusoids(const std::vector<DampedPole>& poles, double start_s, double step_s)
      : m_start_s(start_s),
        m_step_s(step_s),
        m_values(kBlock, 2 * static_cast<Index>(poles.size())) {
    for (std::size_t k = 0; k < poles.size(); ++k) {
      m_exponents.push_back(exponent_of(poles[k]));
      for (Index l = 0; l < kBlock; ++l) {
        const Complex value = std::exp(m_exponents[k] * (static_cast<double>(l) * step_s));
        m_values(l, 2 * static_cast<Index>(k)) = value.real();
        m_values(l, 2 * static_cast<Index>(k) + 1) = value.imag();
      }
    }
    m_timed =
        VectorXd::LinSpaced(kBlock, 0.0, static_cast<double>(kBlock - 1) * step_s).asDiagonal() *
        m_values;
  }

  /// Cosine and sine of each pole within a block, and those times the time in the block.
  [[nodiscard]] const MatrixXd& values() const { return m_values; }
  [[nodiscard]] const MatrixXd& timed() const { return m_timed; }

  [[nodiscard]] double start_of(Index block) const {
    return m_start_s + static_cast<double>(block * kBlock) * m_step_s;
  }
  [[nodiscard]] Complex factor(std::size_t k, Index block) const {
    return std::exp(m_exponents[k] * start_of(block));
  }

 private:
  double m_start_s;
  double m_step_s;
  std::vector<Complex> m_exponents;
  MatrixXd m_values;
  MatrixXd m_timed;
};

EvenRecord::EvenRecord(const SampleSeries& series, double step_s)
    : m_series(&series), m_step_s(step_s), m_zoomed(series.value, series.time_s(0), step_s, {}) {}

std::optional<EvenRecord> EvenRecord::from(const SampleSeries& series, const VectorXd& weights) {
  const Index n = series.time_s.size();
  if (n < kLongRecord) return std::nullopt;
  const double start = series.time_s(0);
  const double step = (series.time_s(n - 1) - start) / static_cast<double>(n - 1);
  for (Index i = 0; i < n; ++i) {
    const double off = series.time_s(i) - (start + static_cast<double>(i) * step);
    if (!(std::abs(off) <= kOffGrid * step)) return std::nullopt;
  }
  EvenRecord out(series, step);
  out.sum_up_alone();
  if (weights.size() > 0 && !out.set_weights(weights)) return std::nullopt;
  return out;
}

Index EvenRecord::num_used() const {
  return m_series->value.size() - static_cast<Index>(m_excluded.size());
}

VectorXd EvenRecord::weights() const {
  VectorXd out = VectorXd::Constant(m_series->value.size(), m_weight);
  for (const Index i : m_excluded) out(i) = 0.0;
  return out;
}

bool EvenRecord::set_weights(const VectorXd& weights) {
  const double weight = weights.maxCoeff();
  std::vector<Index> excluded;
  for (Index i = 0; i < weights.size(); ++i) {
    if (weights(i) == weight) continue;
    if (weights(i) != 0.0) return false;
    excluded.push_back(i);
  }
  if (static_cast<double>(excluded.size()) > kMaxExcludedPart * static_cast<double>(weights.size()))
    return false;
  m_weight = weight;
  if (excluded == m_excluded) return true;
  m_excluded = std::move(excluded);
  m_zoomed = ZoomedRecord(m_series->value, m_series->time_s(0), m_step_s, m_excluded);
  sum_up_alone();
  return true;
}

void EvenRecord::sum_up_alone() {
  m_sum = m_series->value.sum();
  m_timed = m_series->value.dot(m_series->time_s);
  m_squares = m_series->value.squaredNorm();
  for (const Index i : m_excluded) {
    const double value = m_series->value(i);
    m_sum -= value;
    m_timed -= value * m_series->time_s(i);
    m_squares -= value * value;
  }
}

bool EvenRecord::can_evaluate(const std::vector<DampedPole>& poles, double duration_s) {
  return std::all_of(poles.begin(), poles.end(), [&](const DampedPole& pole) {
    return -pole.decay_per_s * duration_s < kMaxExponent;
  });
}

EvenRecord::Moments EvenRecord::moments(const std::vector<DampedPole>& poles) const {
  std::vector<Complex> exponents;
  for (const DampedPole& pole : poles) exponents.push_back(exponent_of(pole));
  exponents.emplace_back(0.0, 0.0);  // the offset
  const auto size = 2 * static_cast<Index>(exponents.size());
  const double start = m_series->time_s(0);
  const double h = m_step_s;
  // e^(s t) before the first sample and after the last.
  std::vector<Complex> firsts;
  std::vector<Complex> lasts;
  for (const Complex s : exponents) {
    firsts.push_back(std::exp(s * start));
    lasts.push_back(std::exp(s * (h * static_cast<double>(m_series->value.size()))));
  }
  // t^q = (start + n h)^q.
  const auto of_times = [&](Complex s, Complex first, Complex last) {
    const auto sum = geometric_moments(s * h, m_series->value.size(), last);
    return std::array<Complex, 3>{
        first * sum[0],
        first * (start * sum[0] + h * sum[1]),
        first * (start * start * sum[0] + 2.0 * start * h * sum[1] + h * h * sum[2])};
  };
  Moments out;
  out.fill(MatrixXd::Zero(size, size));
  for (std::size_t j = 0; j < exponents.size(); ++j) {
    for (std::size_t k = 0; k <= j; ++k) {
      const auto sums =
          of_times(exponents[j] + exponents[k], firsts[j] * firsts[k], lasts[j] * lasts[k]);
      const auto differences = of_times(exponents[j] + std::conj(exponents[k]),
                                        firsts[j] * std::conj(firsts[k]),
                                        lasts[j] * std::conj(lasts[k]));
      for (std::size_t q = 0; q < 3; ++q) {
        const Complex plus = 0.5 * (differences[q] + sums[q]);
        const Complex minus = 0.5 * (differences[q] - sums[q]);
        Eigen::Matrix2d block;
        block << plus.real(), -minus.imag(), plus.imag(), minus.real();
        const Index row = 2 * static_cast<Index>(j);
        const Index column = 2 * static_cast<Index>(k);
        out[q].block<2, 2>(row, column) = block;
        out[q].block<2, 2>(column, row) = block.transpose();
      }
    }
  }
  VectorXd v(size);
  for (const Index i : m_excluded) {
    const double t = m_series->time_s(i);
    for (std::size_t k = 0; k < exponents.size(); ++k) {
      const Complex value = std::exp(exponents[k] * t);
      v.segment<2>(2 * static_cast<Index>(k)) << value.real(), value.imag();
    }
    for (std::size_t q = 0; q < 3; ++q) out[q] -= std::pow(t, q) * v * v.transpose();
  }
  return out;
}

EvenRecord::Sums EvenRecord::sum_up(const std::vector<DampedPole>& poles,
                                    bool fit_drift,
                                    const VectorXd& coefficients,
                                    bool timed,
                                    double& squares) const {
  const Sinusoids sinusoids(poles, m_series->time_s(0), m_step_s);
  const Index n = m_series->value.size();
  const Index first = column_of_pole(fit_drift, 0);
  const double duration = duration_of(*m_series);
  Sums out{VectorXd::Zero(first + 2 * static_cast<Index>(poles.size())),
           VectorXd::Zero(2 * static_cast<Index>(poles.size()))};
  const VectorXd model =
      coefficients.size() > 0 ? evaluate_model(poles, fit_drift, coefficients) : VectorXd();
  auto excluded = m_excluded.begin();
  for (Index begin = 0; begin < n; begin += kBlock * kBlocksTogether) {
    const Index count = std::min(n - begin, kBlock * kBlocksTogether);
    const Index blocks = (count + kBlock - 1) / kBlock;
    MatrixXd r = MatrixXd::Zero(kBlock, blocks);
    Eigen::Map<VectorXd> flat(r.data(), r.size());
    flat.head(count) = m_series->value.segment(begin, count);
    if (model.size() > 0) flat.head(count) -= model.segment(begin, count);
    for (; excluded != m_excluded.end() && *excluded < begin + count; ++excluded)
      flat(*excluded - begin) = 0.0;
    squares += flat.squaredNorm();
    out.basis(0) += flat.sum();
    if (fit_drift)
      out.basis(1) += flat.head(count).dot(m_series->time_s.segment(begin, count)) / duration;
    const MatrixXd within = sinusoids.values().transpose() * r;
    const MatrixXd within_timed = timed ? MatrixXd(sinusoids.timed().transpose() * r) : MatrixXd();
    for (Index b = 0; b < blocks; ++b) {
      const Index block = begin / kBlock + b;
      for (std::size_t k = 0; k < poles.size(); ++k) {
        const Index at = 2 * static_cast<Index>(k);
        const Complex factor = sinusoids.factor(k, block);
        const Complex sum = factor * Complex(within(at, b), within(at + 1, b));
        out.basis.segment<2>(first + at) += Eigen::Vector2d(sum.real(), sum.imag());
        if (!timed) continue;
        const Complex late = factor * Complex(within_timed(at, b), within_timed(at + 1, b)) +
                             sinusoids.start_of(block) * sum;
        out.timed.segment<2>(at) += Eigen::Vector2d(late.real(), late.imag());
      }
    }
  }
  return out;
}

EvenRecord::Sums EvenRecord::sum_up_quickly(const std::vector<DampedPole>& poles,
                                            bool fit_drift,
                                            bool timed) const {
  const Index first = column_of_pole(fit_drift, 0);
  const auto num = 2 * static_cast<Index>(poles.size());
  Sums out{VectorXd(first + num), VectorXd(timed ? num : 0)};
  out.basis(0) = m_sum;
  if (fit_drift) out.basis(1) = m_timed / duration_of(*m_series);
  for (std::size_t k = 0; k < poles.size(); ++k) {
    const ZoomedRecord::Sums sums = m_zoomed.at(exponent_of(poles[k]));
    const Index at = 2 * static_cast<Index>(k);
    out.basis.segment<2>(first + at) << sums.plain.real(), sums.plain.imag();
    if (timed) out.timed.segment<2>(at) << sums.timed.real(), sums.timed.imag();
  }
  return out;
}

VectorXd EvenRecord::evaluate_model(const std::vector<DampedPole>& poles,
                                    bool fit_drift,
                                    const VectorXd& coefficients) const {
  const Sinusoids sinusoids(poles, m_series->time_s(0), m_step_s);
  const Index n = m_series->value.size();
  VectorXd out(n);
  for (Index begin = 0; begin < n; begin += kBlock * kBlocksTogether) {
    const Index count = std::min(n - begin, kBlock * kBlocksTogether);
    const Index blocks = (count + kBlock - 1) / kBlock;
    MatrixXd turned(2 * static_cast<Index>(poles.size()), blocks);
    for (Index b = 0; b < blocks; ++b) {
      for (std::size_t k = 0; k < poles.size(); ++k) {
        // a cos + b sin = Re((a - i b) φ).
        const Index column = column_of_pole(fit_drift, k);
        const Complex c = Complex(coefficients(column), -coefficients(column + 1)) *
                          sinusoids.factor(k, begin / kBlock + b);
        turned.col(b).segment<2>(2 * static_cast<Index>(k)) << c.real(), -c.imag();
      }
    }
    const MatrixXd values = sinusoids.values() * turned;
    out.segment(begin, count) = Eigen::Map<const VectorXd>(values.data(), count);
  }
  out.array() += coefficients(0);
  if (fit_drift) out += coefficients(1) / duration_of(*m_series) * m_series->time_s;
  return out;
}

std::optional<ProjectedFit> EvenRecord::fit_projected(const std::vector<DampedPole>& poles,
                                                      bool fit_drift,
                                                      bool with_derivatives) const {
  const double duration = duration_of(*m_series);
  if (!can_evaluate(poles, duration)) return std::nullopt;
  const auto [m0, m1, m2] = moments(poles);
  const Index num = 2 * static_cast<Index>(poles.size());
  const Index first = column_of_pole(fit_drift, 0);
  const Index columns = first + num;
  // B^T B and B^T (t B), from the moments of (poles, 1).
  MatrixXd gram(columns, columns);
  MatrixXd by_timed(columns, num);
  gram.bottomRightCorner(num, num) = m0.topLeftCorner(num, num);
  by_timed.bottomRows(num) = m1.topLeftCorner(num, num);
  gram(0, 0) = m0(num, num);
  gram.row(0).tail(num) = m0.row(num).head(num);
  by_timed.row(0) = m1.row(num).head(num);
  if (fit_drift) {
    gram(0, 1) = m1(num, num) / duration;
    gram(1, 1) = m2(num, num) / (duration * duration);
    gram.row(1).tail(num) = m1.row(num).head(num) / duration;
    by_timed.row(1) = m2.row(num).head(num) / duration;
  }
  gram.triangularView<Eigen::StrictlyLower>() = gram.transpose();

  ProjectedFit out;
  out.triangle = regular_triangle(gram);
  Sums left = sum_up_quickly(poles, fit_drift, with_derivatives);
  const VectorXd right = left.basis;
  out.coefficients = solve_normal(out.triangle, right);
  left.basis -= gram * out.coefficients;
  out.sum_of_squares = m_squares - out.coefficients.dot(right + left.basis);
  const double cancelling = out.coefficients.cwiseAbs2().dot(gram.diagonal());
  if (with_derivatives) left.timed -= by_timed.transpose() * out.coefficients;
  if (!(out.sum_of_squares > kLeastZoomedResidual * m_squares &&
        cancelling < kMaxCancelling * m_squares)) {
    // The residual itself, not its square by subtraction.
    out.sum_of_squares = 0.0;
    left = sum_up(poles, fit_drift, out.coefficients, with_derivatives, out.sum_of_squares);
    if (!(out.sum_of_squares > kLeastResidual * m_squares)) return std::nullopt;
  }
  // As in the plain way: what the residual still has in the span of B corrects the coefficients.
  const VectorXd correction = solve_normal(out.triangle, left.basis);
  if (with_derivatives) {
    MatrixXd turn = MatrixXd::Zero(num, num);  // D = t B turn
    for (Index j = 0; j < num; j += 2) {
      const double a = out.coefficients(first + j);
      const double b = out.coefficients(first + j + 1);
      turn.block<2, 2>(j, j) << kTwoPi * b, -a, -kTwoPi * a, -b;
    }
    const MatrixXd basis_by_d = by_timed * turn;
    out.inside = solve_transposed_triangle(out.triangle, basis_by_d);
    out.normal =
        turn.transpose() * m2.topLeftCorner(num, num) * turn - out.inside.transpose() * out.inside;
    out.gradient = basis_by_d.transpose() * correction - turn.transpose() * left.timed;
    out.inside *= m_weight;
    out.normal *= m_weight * m_weight;
    out.gradient *= m_weight * m_weight;
  }
  out.coefficients += correction;
  out.sum_of_squares =
      std::max(out.sum_of_squares - left.basis.dot(correction), 0.0) * m_weight * m_weight;
  out.triangle *= m_weight;
  return out;
}

}  // namespace twang
