// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/track_noise.hpp"

#include "core/dense_algebra.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace twang::detail {
namespace {

/// Length of the windows, and how many of their dimensions are not noise.
struct WindowShape {
  Eigen::Index length;  // [frames]
  Eigen::Index signal;

  [[nodiscard]] Eigen::Index noise() const { return length - signal; }
};
// Three sinusoids, or one with two overtones, offset and drift; where gaps leave few such windows,
// two sinusoids and so on.
constexpr std::array kShapes = {WindowShape{24, 8}, WindowShape{12, 6}};
constexpr std::size_t kFewestWindows = 40;
constexpr double kQuantile = 0.4;
constexpr double kQuantileInSigmas = -0.25335;  // of a Gaussian variable
constexpr int kRounds = 4;
constexpr double kStandsOut = 3.0;  // times the quantile
constexpr double kMoves_px = 0.3;
// The error of a still marker in a compressed film over the scatter of moving ones.
constexpr double kStillPart = 0.3;
// H.264 at a rate factor of 18 to 23, markers in motion.
constexpr double kUsualCoding_px = 0.02;

/// The quantile of a chi-square variable over its mean (Wilson & Hilferty 1931).
double quantile_over_mean(double freedom) {
  const double spread = 2.0 / (9.0 * freedom);
  return std::pow(1.0 - spread + kQuantileInSigmas * std::sqrt(spread), 3);
}

Eigen::Vector2d mean_of_finite(const std::vector<Eigen::Vector2d>& positions, double& count) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  count = 0.0;
  for (const Eigen::Vector2d& px : positions) {
    if (!px.allFinite()) continue;
    sum += px;
    count += 1.0;
  }
  return count > 0.0 ? Eigen::Vector2d(sum / count) : sum;
}

/// Starts of the windows without a gap.
std::vector<std::size_t> whole_windows(const std::vector<Eigen::Vector2d>& positions,
                                       std::size_t length) {
  std::vector<std::size_t> starts;
  std::size_t run = 0;
  for (std::size_t n = 0; n < positions.size(); ++n) {
    run = positions[n].allFinite() ? run + 1 : 0;
    if (run >= length) starts.push_back(n + 1 - length);
  }
  return starts;
}

/// The windows of a track, one a column for either coordinate.
Eigen::MatrixXd gather_windows(const std::vector<Eigen::Vector2d>& positions,
                               const Eigen::Vector2d& mean,
                               const std::vector<std::size_t>& starts,
                               Eigen::Index length) {
  Eigen::MatrixXd windows(length, 2 * static_cast<Eigen::Index>(starts.size()));
  for (Eigen::Index w = 0; w < windows.cols(); ++w) {
    const std::size_t start = starts[static_cast<std::size_t>(w / 2)];
    for (Eigen::Index i = 0; i < length; ++i) {
      windows(i, w) = (positions[start + static_cast<std::size_t>(i)] - mean)[w % 2];
    }
  }
  return windows;
}

/// The windows' mean square in the noise dimensions, a low quantile made a mean. Windows that stand
/// out (a release, a hand) do not shape the subspace a second time.
double square_outside_signal(const Eigen::MatrixXd& windows, const WindowShape& shape) {
  const Eigen::Index count = windows.cols() / 2;
  const auto freedom = static_cast<double>(2 * shape.noise());
  const auto rank = static_cast<std::size_t>(kQuantile * static_cast<double>(count));
  std::vector<bool> used(static_cast<std::size_t>(count), true);
  double quantile = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(shape.length, shape.length);
    for (Eigen::Index w = 0; w < count; ++w) {
      if (!used[static_cast<std::size_t>(w)]) continue;
      covariance.selfadjointView<Eigen::Lower>().rankUpdate(windows.middleCols(2 * w, 2));
    }
    // Eigenvalues ascend: the first columns are the noise.
    const Eigen::MatrixXd noise =
        symmetric_eigen(covariance).vectors.leftCols(shape.noise()).transpose() * windows;
    std::vector<double> outside;
    for (Eigen::Index w = 0; w < count; ++w) {
      outside.push_back(noise.middleCols(2 * w, 2).squaredNorm() / freedom);
    }
    std::vector<double> sorted = outside;
    std::sort(sorted.begin(), sorted.end());
    quantile = sorted[rank];
    const double most = std::max(kStandsOut * quantile, sorted[sorted.size() / 2]);
    for (std::size_t w = 0; w < outside.size(); ++w) used[w] = outside[w] <= most;
  }
  // The subspace is fitted to the same windows and takes some of their noise.
  const double taken = 1.0 - static_cast<double>(shape.signal) / static_cast<double>(count);
  return quantile / (quantile_over_mean(freedom) * taken);
}

}  // namespace

std::optional<TrackNoise> measure_track_noise(const std::vector<Eigen::Vector2d>& position_px) {
  double count = 0.0;
  const Eigen::Vector2d mean = mean_of_finite(position_px, count);
  for (const WindowShape& shape : kShapes) {
    const auto starts = whole_windows(position_px, static_cast<std::size_t>(shape.length));
    if (starts.size() < kFewestWindows) continue;
    const Eigen::MatrixXd windows = gather_windows(position_px, mean, starts, shape.length);
    double square = 0.0;
    for (const Eigen::Vector2d& px : position_px) {
      if (px.allFinite()) square += (px - mean).squaredNorm();
    }
    return TrackNoise{std::sqrt(square_outside_signal(windows, shape)),
                      std::sqrt(square / (2.0 * count))};
  }
  return std::nullopt;
}

std::vector<double> widen_by_scatter(
    const std::vector<const std::vector<Eigen::Vector2d>*>& position_px,
    const std::vector<std::vector<double>*>& sigma_px,
    const std::vector<bool>& cut_out) {
  const std::size_t num_markers = position_px.size();
  std::vector<double> excess(num_markers, kUsualCoding_px);
  std::vector<bool> moves(num_markers, true);
  std::vector<double> of_moving;
  for (std::size_t i = 0; i < num_markers; ++i) {
    const auto noise = measure_track_noise(*position_px[i]);
    if (!noise) continue;
    double square = 0.0;
    double count = 0.0;
    for (const double sigma : *sigma_px[i]) {
      if (!std::isfinite(sigma)) continue;
      square += sigma * sigma;
      count += 1.0;
    }
    excess[i] = std::sqrt(std::max(0.0, noise->scatter_px * noise->scatter_px - square / count));
    moves[i] = noise->motion_px > kMoves_px;
    if (i < cut_out.size() && cut_out[i] && moves[i]) {
      const double shrunk = std::min(1.0, noise->scatter_px / std::sqrt(square / count));
      for (double& sigma : *sigma_px[i]) sigma *= shrunk;
    }
    if (moves[i]) of_moving.push_back(excess[i]);
  }
  double still = kStillPart * kUsualCoding_px;
  if (!of_moving.empty()) {
    const auto middle = of_moving.begin() + static_cast<std::ptrdiff_t>(of_moving.size() / 2);
    std::nth_element(of_moving.begin(), middle, of_moving.end());
    still = kStillPart * *middle;
  }
  for (std::size_t i = 0; i < num_markers; ++i) {
    if (!moves[i]) excess[i] = std::max(excess[i], still);
    for (double& sigma : *sigma_px[i]) sigma = std::hypot(sigma, excess[i]);
  }
  return excess;
}

}  // namespace twang::detail
