// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/motion_scales.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr std::array<std::string_view, 5> kUnits = {"m", "mm", "px", "rad", "deg"};
/// The noise of a channel is taken to be within these parts of its range; of noise alone the range
/// is about seven sigmas.
constexpr double kLeastNoise = 1e-3;
constexpr double kMostNoise = 1.0 / 7.0;
/// The lower quartile of |y_1 - (y_0 + y_2) / 2| for white noise of unit sigma.
constexpr double kQuartileOfBends = 0.3186 * 1.2247;

/// Empty: none that is known.
std::string_view unit_of(std::string_view name) {
  const std::size_t at = name.rfind('_');
  if (at == std::string_view::npos) return {};
  const std::string_view suffix = name.substr(at + 1);
  return std::find(kUnits.begin(), kUnits.end(), suffix) != kUnits.end() ? suffix
                                                                         : std::string_view{};
}

RowVectorXd ranges(const MatrixXd& value) {
  return value.colwise().maxCoeff() - value.colwise().minCoeff();
}

RowVectorXd without_zeros(const RowVectorXd& scales) {
  return (scales.array() > 0.0).select(scales, 1.0);
}

/// Sigma of the samples whose neighbours foretell them best: those at rest.
double noise_of(const VectorXd& value) {
  const Index n = value.size();
  VectorXd bends =
      (value.segment(1, n - 2) - 0.5 * (value.head(n - 2) + value.tail(n - 2))).cwiseAbs();
  double* quartile = bends.data() + bends.size() / 4;
  std::nth_element(bends.data(), quartile, bends.data() + bends.size());
  return *quartile / kQuartileOfBends;
}

}  // namespace

RowVectorXd scales_by_unit(const MatrixXd& value, const std::vector<std::string>& names) {
  RowVectorXd out = ranges(value);
  std::map<std::string_view, double> largest;
  for (Index c = 0; c < out.size(); ++c) {
    double& range = largest[unit_of(names[static_cast<std::size_t>(c)])];
    range = std::max(range, out(c));
  }
  for (Index c = 0; c < out.size(); ++c) {
    const std::string_view unit = unit_of(names[static_cast<std::size_t>(c)]);
    if (!unit.empty()) out(c) = largest[unit];
  }
  return without_zeros(out);
}

RowVectorXd scales_by_noise(const MatrixXd& value) {
  RowVectorXd out = ranges(value);
  if (value.rows() < 3) return without_zeros(out);
  for (Index c = 0; c < out.size(); ++c)
    out(c) = std::clamp(noise_of(value.col(c)), kLeastNoise * out(c), kMostNoise * out(c));
  return without_zeros(out);
}

}  // namespace twang
