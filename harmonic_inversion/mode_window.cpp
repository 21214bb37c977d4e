// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/mode_window.hpp"

#include "core/dense_algebra.hpp"
#include "harmonic_inversion/evaluate_modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kIterations = 30;
constexpr double kStep = 1e-10;   // of f, at which the iteration stops
constexpr Index kTogether = 256;  // samples

/// Sums over one channel for the unknowns f, d and its own two.
struct ChannelSums {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double squares = 0.0;
};

ChannelSums sum_up(
    const VectorXd& t, const VectorXd& y, double f, double d, const Eigen::Vector2d& x) {
  ChannelSums out;
  Eigen::Matrix<double, Eigen::Dynamic, 4> rows(kTogether, 4);
  VectorXd r(kTogether);
  for (Index first = 0; first < t.size(); first += kTogether) {
    const Index count = std::min(kTogether, t.size() - first);
    const auto time = t.segment(first, count);
    const Eigen::VectorXcd values = exponentials(1.0, {-d, kTwoPi * f}, time);
    auto block = rows.topRows(count);
    block.col(2) = values.real();
    block.col(3) = values.imag();
    r.head(count) = y.segment(first, count) - block.rightCols<2>() * x;
    block.col(0) = kTwoPi * time.cwiseProduct(x(1) * block.col(2) - x(0) * block.col(3));
    block.col(1) = -time.cwiseProduct(block.rightCols<2>() * x);
    out.normal.noalias() += block.transpose().lazyProduct(block);
    out.right.noalias() += block.transpose() * r.head(count);
    out.squares += r.head(count).squaredNorm();
  }
  return out;
}

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
      const auto at = static_cast<std::size_t>(c);
      const ChannelSums sums =
          sum_up(samples.time_s[at], samples.value[at], f, d, x.segment<2>(2 * c));
      const std::array<Index, 4> places = {0, 1, 2 + 2 * c, 3 + 2 * c};
      normal(places, places) += sums.normal;
      right(places) += sums.right;
      fit.sum_of_squares += sums.squares;
    }
    const bool only_amplitudes = iteration == 0;  // f and d have no effect before there are some
    const Index moving = only_amplitudes ? columns - 2 : columns;
    const auto triangle = cholesky(normal.bottomRightCorner(moving, moving));
    if (!triangle) return std::nullopt;
    const auto solve = [&](const MatrixXd& b) {
      return solve_triangle(*triangle, solve_transposed_triangle(*triangle, b));
    };
    if (only_amplitudes) {
      x = solve(right.tail(moving));
      continue;
    }
    if (iteration > 1 && step <= kStep * f) {
      fit.frequency_hz = f;
      fit.decay_per_s = d;
      fit.amplitude = x.norm();
      fit.freedom = samples.size() - columns;
      fit.covariance = solve(MatrixXd::Identity(columns, columns)).topLeftCorner<2, 2>();
      return fit;
    }
    const VectorXd change = solve(right);
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
