// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/evaluate_modes.hpp"

#include "core/constants.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>

namespace twang {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// Products of this many factors in a row are as good as powers.
constexpr Index kInARow = 64;
/// Stamps off an even row by less than this part of a step: a phase error of 3e-9 at Nyquist.
constexpr double kOffRow = 1e-9;

/// The step between stamps that are even; nothing if they are not.
std::optional<double> step_of(const Eigen::Ref<const VectorXd>& time_s) {
  const Index n = time_s.size();
  if (n < 2) return std::nullopt;
  const double step_s = (time_s(n - 1) - time_s(0)) / static_cast<double>(n - 1);
  for (Index i = 0; i < n; ++i) {
    const double off = time_s(i) - time_s(0) - static_cast<double>(i) * step_s;
    if (!(std::abs(off) <= kOffRow * step_s)) return std::nullopt;
  }
  return step_s;
}

/// exponentials() at stamps of which `step_s` says how far they are apart if they are even.
void fill_row(Complex amplitude,
              Complex s,
              const Eigen::Ref<const VectorXd>& row,
              std::optional<double> step_s,
              Eigen::Ref<VectorXcd> out) {
  if (!step_s) {
    for (Index i = 0; i < row.size(); ++i) out(i) = amplitude * std::exp(s * row(i));
    return;
  }
  const Complex factor = std::exp(s * *step_s);
  Complex value = amplitude * std::exp(s * row(0));
  out(0) = value;
  for (Index i = 1; i < row.size(); ++i) {
    // Written out, for std::complex looks for infinities.
    value = {value.real() * factor.real() - value.imag() * factor.imag(),
             value.real() * factor.imag() + value.imag() * factor.real()};
    out(i) = value;
  }
}

}  // namespace

VectorXcd exponentials(Complex amplitude, Complex s, const Eigen::Ref<const VectorXd>& time_s) {
  VectorXcd out(time_s.size());
  for (Index first = 0; first < time_s.size(); first += kInARow) {
    const Index count = std::min(kInARow, time_s.size() - first);
    const auto row = time_s.segment(first, count);
    fill_row(amplitude, s, row, step_of(row), out.segment(first, count));
  }
  return out;
}

VectorXd evaluate_modes(const InversionResult& result,
                        std::size_t channel,
                        const VectorXd& time_s) {
  VectorXd out = result.offsets[channel] + result.drifts_per_s[channel] * time_s.array();
  VectorXcd values(kInARow);
  for (Index first = 0; first < time_s.size(); first += kInARow) {
    const Index count = std::min(kInARow, time_s.size() - first);
    const auto row = time_s.segment(first, count);
    const std::optional<double> step_s = step_of(row);
    for (const DampedSinusoid& mode : result.modes) {
      const SinusoidInChannel& part = mode.channels[channel];
      fill_row(std::polar(part.amplitude, part.phase_rad),
               Complex(-mode.decay_per_s, kTwoPi * mode.frequency_hz),
               row,
               step_s,
               values.head(count));
      out.segment(first, count) += values.head(count).imag();
    }
  }
  return out;
}

}  // namespace twang
