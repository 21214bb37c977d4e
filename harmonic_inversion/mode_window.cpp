// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/mode_window.hpp"

#include <Eigen/Cholesky>

#include <cmath>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kIterations = 30;
constexpr double kStep = 1e-10;  // of f, at which the iteration stops

}  // namespace

std::optional<WindowFit> fit_window(const WindowSamples& samples, double f, double d) {
  const Index columns = samples.num_unknowns();
  const auto num_channels = static_cast<Index>(samples.value.size());
  VectorXd x = VectorXd::Zero(2 * num_channels);  // cosine and sine of each channel
  WindowFit fit;
  double step = 0.0;
  for (int iteration = 0; iteration <= kIterations; ++iteration) {
    MatrixXd normal = MatrixXd::Zero(columns, columns);
    VectorXd right = VectorXd::Zero(columns);
    fit.sum_of_squares = 0.0;
    for (Index c = 0; c < num_channels; ++c) {
      const VectorXd& t = samples.time_s[static_cast<std::size_t>(c)];
      const VectorXd& y = samples.value[static_cast<std::size_t>(c)];
      for (Index i = 0; i < t.size(); ++i) {
        const double size = std::exp(-d * t(i));
        const double cosine = size * std::cos(kTwoPi * f * t(i));
        const double sine = size * std::sin(kTwoPi * f * t(i));
        const double a = x(2 * c);
        const double b = x(2 * c + 1);
        const double model = a * cosine + b * sine;
        VectorXd row = VectorXd::Zero(columns);
        row(0) = kTwoPi * t(i) * (b * cosine - a * sine);
        row(1) = -t(i) * model;
        row(2 + 2 * c) = cosine;
        row(3 + 2 * c) = sine;
        const double r = y(i) - model;
        fit.sum_of_squares += r * r;
        normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
        right += r * row;
      }
    }
    normal = normal.selfadjointView<Eigen::Lower>();
    const bool only_amplitudes = iteration == 0;  // f and d have no effect before there are some
    if (only_amplitudes) {
      x = normal.bottomRightCorner(columns - 2, columns - 2).ldlt().solve(right.tail(columns - 2));
      continue;
    }
    const Eigen::LDLT<MatrixXd> ldlt(normal);
    if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0.0)) return std::nullopt;
    if (iteration > 1 && step <= kStep * f) {
      fit.frequency_hz = f;
      fit.decay_per_s = d;
      fit.amplitude = x.norm();
      fit.freedom = samples.size() - columns;
      fit.covariance = ldlt.solve(MatrixXd::Identity(columns, columns)).topLeftCorner<2, 2>();
      return fit;
    }
    const VectorXd change = ldlt.solve(right);
    if (!change.allFinite()) return std::nullopt;
    f += change(0);
    d += change(1);
    x += change.tail(columns - 2);
    step = std::abs(change(0)) + std::abs(change(1)) / kTwoPi;
    if (!(f > 0.0)) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace twang
