// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/track_noise.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace twang::detail {
namespace {

constexpr Eigen::Index kWindow = 24;  // frames
// Dimensions of what is not noise: three sinusoids, or one with two overtones, offset and drift.
constexpr Eigen::Index kSignal = 8;
constexpr std::size_t kFewestWindows = 40;
constexpr double kQuantile = 0.4;
// That quantile of a chi-square variable over its mean, with the freedom of two coordinates' noise
// dimensions (Wilson & Hilferty 1931: (1 − 2/9k + z √(2/9k))³, z = −0.2533 at 40 %).
constexpr double kQuantileOverMean = 0.9563;
constexpr double kMoves_px = 0.3;
// The error of a still marker in a compressed film over the scatter of moving ones.
constexpr double kStillPart = 0.3;
// H.264 at a rate factor of 18 to 23, markers in motion.
constexpr double kUsualCoding_px = 0.02;

using WindowVector = Eigen::Matrix<double, kWindow, 1>;
using WindowMatrix = Eigen::Matrix<double, kWindow, kWindow>;

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
std::vector<std::size_t> whole_windows(const std::vector<Eigen::Vector2d>& positions) {
  std::vector<std::size_t> starts;
  std::size_t run = 0;
  for (std::size_t n = 0; n < positions.size(); ++n) {
    run = positions[n].allFinite() ? run + 1 : 0;
    if (run >= static_cast<std::size_t>(kWindow)) {
      starts.push_back(n + 1 - static_cast<std::size_t>(kWindow));
    }
  }
  return starts;
}

}  // namespace

std::optional<TrackNoise> measure_track_noise(const std::vector<Eigen::Vector2d>& position_px) {
  const std::vector<std::size_t> starts = whole_windows(position_px);
  if (starts.size() < kFewestWindows) return std::nullopt;
  double count = 0.0;
  const Eigen::Vector2d mean = mean_of_finite(position_px, count);
  const auto window = [&](std::size_t start, int axis) {
    WindowVector values;
    for (Eigen::Index i = 0; i < kWindow; ++i) {
      values[i] = position_px[start + static_cast<std::size_t>(i)][axis] - mean[axis];
    }
    return values;
  };
  WindowMatrix covariance = WindowMatrix::Zero();
  for (const std::size_t start : starts) {
    for (const int axis : {0, 1}) {
      covariance.selfadjointView<Eigen::Lower>().rankUpdate(window(start, axis));
    }
  }
  // Eigenvalues ascend: the first columns are the noise.
  const Eigen::SelfAdjointEigenSolver<WindowMatrix> solver(covariance);
  const auto noise = solver.eigenvectors().leftCols<kWindow - kSignal>();
  std::vector<double> outside;
  outside.reserve(starts.size());
  for (const std::size_t start : starts) {
    double square = 0.0;
    for (const int axis : {0, 1}) {
      square += (noise.transpose() * window(start, axis)).squaredNorm();
    }
    outside.push_back(square / static_cast<double>(2 * (kWindow - kSignal)));
  }
  const auto place = outside.begin() + static_cast<std::ptrdiff_t>(
                                           kQuantile * static_cast<double>(outside.size()));
  std::nth_element(outside.begin(), place, outside.end());
  double square = 0.0;
  for (const Eigen::Vector2d& px : position_px) {
    if (px.allFinite()) square += (px - mean).squaredNorm();
  }
  // The subspace is fitted to the same windows and takes some of their noise.
  const double taken = 1.0 - static_cast<double>(kSignal) / static_cast<double>(starts.size());
  return TrackNoise{std::sqrt(*place / (kQuantileOverMean * taken)),
                    std::sqrt(square / (2.0 * count))};
}

void widen_by_scatter(const std::vector<const std::vector<Eigen::Vector2d>*>& position_px,
                      const std::vector<std::vector<double>*>& sigma_px) {
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
    if (moves[i]) of_moving.push_back(excess[i]);
  }
  double still = kStillPart * kUsualCoding_px;
  if (!of_moving.empty()) {
    const auto middle = of_moving.begin() + static_cast<std::ptrdiff_t>(of_moving.size() / 2);
    std::nth_element(of_moving.begin(), middle, of_moving.end());
    still = kStillPart * *middle;
  }
  for (std::size_t i = 0; i < num_markers; ++i) {
    const double added = moves[i] ? excess[i] : std::max(excess[i], still);
    for (double& sigma : *sigma_px[i]) sigma = std::hypot(sigma, added);
  }
}

}  // namespace twang::detail
