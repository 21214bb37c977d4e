// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/evaluate_modes.hpp"

#include "core/constants.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace twang {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::VectorXd;

/// Products of this many factors in a row are as good as powers.
constexpr Index kInARow = 64;
/// Stamps off an even row by less than this part of a step: a phase error of 3e-9 at Nyquist.
constexpr double kOffRow = 1e-9;

bool is_even(const Eigen::Ref<const VectorXd>& time_s, double step_s) {
  for (Index i = 0; i < time_s.size(); ++i) {
    const double off = time_s(i) - time_s(0) - static_cast<double>(i) * step_s;
    if (!(std::abs(off) <= kOffRow * step_s)) return false;
  }
  return true;
}

}  // namespace

VectorXd evaluate_modes(const InversionResult& result,
                        std::size_t channel,
                        const VectorXd& time_s) {
  VectorXd out = result.offsets[channel] + result.drifts_per_s[channel] * time_s.array();
  for (Index first = 0; first < time_s.size(); first += kInARow) {
    const Index count = std::min(kInARow, time_s.size() - first);
    const auto row = time_s.segment(first, count);
    const double step =
        count > 1 ? (row(count - 1) - row(0)) / static_cast<double>(count - 1) : 1.0;
    const bool even = is_even(row, step);
    for (const DampedSinusoid& mode : result.modes) {
      const SinusoidInChannel& part = mode.channels[channel];
      const Complex exponent(-mode.decay_per_s, kTwoPi * mode.frequency_hz);
      const Complex start = std::polar(part.amplitude, part.phase_rad);
      const Complex factor = std::exp(exponent * step);
      Complex value = start * std::exp(exponent * row(0));
      for (Index i = 0; i < count; ++i) {
        if (i > 0 && even) {
          // Written out, for std::complex looks for infinities.
          value = {value.real() * factor.real() - value.imag() * factor.imag(),
                   value.real() * factor.imag() + value.imag() * factor.real()};
        } else if (i > 0) {
          value = start * std::exp(exponent * row(i));
        }
        out(first + i) += value.imag();
      }
    }
  }
  return out;
}

}  // namespace twang
