// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/robust_factors.hpp"

#include "harmonic_inversion/sample_scatter.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kLeastLimit = 4.0;
/// Expected samples of normal noise beyond the limit: one over this, and less.
constexpr double kRecordsPerAlarm = 10.0;
/// Neighbours, on both sides together, whose scatter a sample is compared with.
constexpr Index kNeighbours = 40;
/// Above this part of the samples it is not outliers but the model that is wrong.
constexpr double kMaxPart = 0.05;

double scatter_of(std::vector<double> magnitude) {
  const auto middle = magnitude.begin() + static_cast<std::ptrdiff_t>(magnitude.size() / 2);
  std::nth_element(magnitude.begin(), middle, magnitude.end());
  return *middle / kMedianOfNormal;
}

/// Scatter of the samples about sample `i`, without itself.
double scatter_about(const VectorXd& magnitude, Index i) {
  const Index count = std::min(kNeighbours + 1, magnitude.size());
  const Index first = std::clamp<Index>(i - kNeighbours / 2, 0, magnitude.size() - count);
  std::vector<double> neighbours;
  for (Index j = first; j < first + count; ++j) {
    if (j != i) neighbours.push_back(magnitude(j));
  }
  return neighbours.empty() ? 0.0 : scatter_of(std::move(neighbours));
}

}  // namespace

VectorXd robust_factors(const VectorXd& residual) {
  const Index n = residual.size();
  VectorXd out = VectorXd::Ones(n);
  const VectorXd magnitude = residual.cwiseAbs();
  const double of_all = scatter_of({magnitude.begin(), magnitude.end()});
  const double limit =
      std::max(kLeastLimit, std::sqrt(2.0 * std::log(kRecordsPerAlarm * static_cast<double>(n))));
  Index count = 0;
  for (Index i = 0; i < n; ++i) {
    if (!(magnitude(i) > limit * of_all)) continue;
    const double z = magnitude(i) / std::max(of_all, scatter_about(magnitude, i));
    if (!(z > limit)) continue;
    const double beyond = std::min((z - limit) / limit, 1.0);
    out(i) = 1.0 - beyond * beyond;
    ++count;
  }
  if (static_cast<double>(count) > kMaxPart * static_cast<double>(n)) out.setOnes();
  return out;
}

}  // namespace twang
