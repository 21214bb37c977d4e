// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/zoomed_record.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kBlocks = 64;
/// Largest |a|, and moments of a block: the first one left out is (1/2)^14 / 14! = 7e-16.
constexpr double kReach = 0.5;
constexpr Index kMoments = 14;
/// A sinusoid is gone after this many decay constants: e^-42 = 6e-19.
constexpr double kGone = 42.0;
/// One that is gone within this many blocks is summed up as it is.
constexpr Index kBriefBlocks = 3;
/// Products of this many factors in a row are as good as powers.
constexpr Index kInARow = 64;
/// Cells that are remembered.
constexpr std::size_t kMaxCells = 256;

}  // namespace

ZoomedRecord::ZoomedRecord(const VectorXd& value,
                           double start_s,
                           double step_s,
                           std::vector<Index> excluded)
    : m_value(&value),
      m_start_s(start_s),
      m_step_s(step_s),
      m_excluded(std::move(excluded)),
      m_length((value.size() + kBlocks - 1) / kBlocks),
      m_half_s(0.5 * static_cast<double>(m_length - 1) * step_s) {}

ZoomedRecord::Sums ZoomedRecord::at(Complex exponent) const {
  const double decay = -exponent.real();
  const double until = kGone / std::max(decay * m_step_s, 1e-300);
  if (until < static_cast<double>(kBriefBlocks * m_length))
    return sum_of_beginning(exponent, static_cast<Index>(until) + 1);
  const Cell& cell = cell_near(exponent);
  const Complex a = (exponent - cell.centre) * m_half_s;
  Eigen::Matrix<double, kMoments, 1> real = Eigen::Matrix<double, kMoments, 1>::Zero();
  Eigen::Matrix<double, kMoments, 1> imag = real;
  Complex power = 1.0;
  for (Index p = 0; p < kMoments; ++p) {
    real(p) = power.real();
    imag(p) = power.imag();
    power *= a / static_cast<double>(p + 1);
  }
  Sums out{};
  const auto times = [&](const auto& re, const auto& im) {
    return Complex(real.dot(re) - imag.dot(im), real.dot(im) + imag.dot(re));
  };
  Complex factor = std::exp(exponent * (m_start_s + m_half_s));
  const Complex step = std::exp(exponent * (static_cast<double>(m_length) * m_step_s));
  for (Index b = 0; b < kBlocks; ++b) {
    const auto re = cell.moments.col(b).head<kMoments + 1>();
    const auto im = cell.moments.col(b).tail<kMoments + 1>();
    const double middle_s = m_start_s + static_cast<double>(b * m_length) * m_step_s + m_half_s;
    const Complex plain = factor * times(re.head<kMoments>(), im.head<kMoments>());
    const Complex within = factor * times(re.tail<kMoments>(), im.tail<kMoments>());
    out.plain += plain;
    out.timed += middle_s * plain + m_half_s * within;
    factor *= step;
  }
  return out;
}

ZoomedRecord::Sums ZoomedRecord::sum_of_beginning(Complex exponent, Index count) const {
  Sums out{};
  const Index end = std::min(count, m_value->size());
  const Complex step = std::exp(exponent * m_step_s);
  auto excluded = m_excluded.begin();
  Complex factor = 0.0;
  for (Index n = 0; n < end; ++n) {
    const double t = m_start_s + static_cast<double>(n) * m_step_s;
    factor = n % kInARow == 0 ? std::exp(exponent * t) : factor * step;
    if (excluded != m_excluded.end() && *excluded == n) {
      ++excluded;
      continue;
    }
    const Complex value = (*m_value)(n)*factor;
    out.plain += value;
    out.timed += t * value;
  }
  return out;
}

const ZoomedRecord::Cell& ZoomedRecord::cell_near(Complex exponent) const {
  for (const Cell& cell : m_cells) {
    if (std::abs(exponent - cell.centre) * m_half_s <= kReach) return cell;
  }
  if (m_cells.size() >= kMaxCells) m_cells.clear();
  m_cells.push_back(make_cell(exponent));
  return m_cells.back();
}

ZoomedRecord::Cell ZoomedRecord::make_cell(Complex centre) const {
  constexpr Index kRows = kMoments + 1;  // one more for the sums with time
  MatrixXd weights(m_length, 2 * kRows);
  const VectorXd x = VectorXd::LinSpaced(m_length, -1.0, 1.0);
  const Complex step = std::exp(centre * m_step_s);
  Complex factor = 0.0;
  for (Index l = 0; l < m_length; ++l) {
    const double t = static_cast<double>(l) * m_step_s - m_half_s;
    factor = l % kInARow == 0 ? std::exp(centre * t) : factor * step;
    weights(l, 0) = factor.real();
    weights(l, kRows) = factor.imag();
  }
  for (Index p = 1; p < kRows; ++p) {
    weights.col(p) = weights.col(p - 1).cwiseProduct(x);
    weights.col(kRows + p) = weights.col(kRows + p - 1).cwiseProduct(x);
  }
  const Index whole = m_value->size() / m_length;
  const Index rest = m_value->size() - whole * m_length;
  Cell out{centre, MatrixXd::Zero(2 * kRows, kBlocks)};
  const Eigen::Map<const MatrixXd> blocks(m_value->data(), m_length, whole);
  out.moments.leftCols(whole).noalias() = weights.transpose() * blocks;
  if (rest > 0) out.moments.col(whole) = weights.topRows(rest).transpose() * m_value->tail(rest);
  for (const Index n : m_excluded)
    out.moments.col(n / m_length) -= (*m_value)(n)*weights.row(n % m_length).transpose();
  return out;
}

}  // namespace twang
