// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <random>

namespace twang::test {

/// Entries uniform in [-amplitude, amplitude], the same for the same seed.
[[nodiscard]] inline Eigen::VectorXd random_vector(Eigen::Index size,
                                                   double amplitude,
                                                   unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  return Eigen::VectorXd::NullaryExpr(size, [&]() { return uniform(generator); });
}

/// d f(x + t direction) / dt at t = 0 by central differences of fourth order with steps `step` and
/// 2 `step`; works for scalars and vectors.
template <class Function>
[[nodiscard]] auto directional_derivative(const Function& f,
                                          const Eigen::VectorXd& x,
                                          const Eigen::VectorXd& direction,
                                          double step) {
  using Value = std::decay_t<decltype(f(x))>;
  const Value near = f(x + step * direction) - f(x - step * direction);
  const Value far = f(x + 2.0 * step * direction) - f(x - 2.0 * step * direction);
  const Value slope = (8.0 * near - far) / (12.0 * step);
  return slope;
}

}  // namespace twang::test
