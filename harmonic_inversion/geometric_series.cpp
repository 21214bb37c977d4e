// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/geometric_series.hpp"

#include <cmath>

namespace twang {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;

/// From |1 - z| N = this on the sums lose no digits by division.
constexpr double kFarFromOne = 30.0;

/// 1 - e^s.
Complex one_minus_exp(Complex s) {
  const double half = std::sin(0.5 * s.imag());
  return {2.0 * half * half - std::expm1(s.real()) * std::cos(s.imag()),
          -std::exp(s.real()) * std::sin(s.imag())};
}

}  // namespace

std::array<Complex, 3> geometric_moments(Complex s, Index count, Complex last) {
  std::array<Complex, 3> sum{};
  const auto all = static_cast<double>(count);
  const Complex rest = one_minus_exp(s);
  if (std::abs(rest) * all > kFarFromOne) {
    const Complex z = 1.0 - rest;
    sum[0] = (1.0 - last) / rest;
    sum[1] = (z * sum[0] - all * last) / rest;
    sum[2] = (z * (sum[0] + 2.0 * sum[1]) - all * all * last) / rest;
    return sum;
  }
  Index have = 0;
  int bits = 0;
  while ((count >> bits) > 0) ++bits;
  for (int bit = bits - 1; bit >= 0; --bit) {
    const auto m = static_cast<double>(have);
    const Complex power = std::exp(s * m);
    sum[2] += power * (sum[2] + 2.0 * m * sum[1] + m * m * sum[0]);
    sum[1] += power * (sum[1] + m * sum[0]);
    sum[0] += power * sum[0];
    have *= 2;
    if (((count >> bit) & 1) == 0) continue;
    const auto n = static_cast<double>(have);
    const Complex next = std::exp(s * n);
    sum[0] += next;
    sum[1] += n * next;
    sum[2] += n * n * next;
    ++have;
  }
  return sum;
}

}  // namespace twang
