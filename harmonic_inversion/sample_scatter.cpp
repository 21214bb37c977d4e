// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/sample_scatter.hpp"

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

/// Variances of less spread than this are all the same: weights by them gain 1e-5 of a sigma.
constexpr double kSameVariance = 1.01;
constexpr double kStep = 1e-12;  // of the extra variance, at which the iteration stops
constexpr int kIterations = 100;
/// Halvings of the extra scatter: outliers need no more digits.
constexpr int kHalvings = 20;

double median(ArrayXd values) {
  double* const middle = values.data() + values.size() / 2;
  std::nth_element(values.data(), middle, values.data() + values.size());
  return *middle;
}

}  // namespace

VectorXd SampleScatter::variances(const VectorXd& sigma, Index count) const {
  if (sigma.size() == 0) return VectorXd::Constant(count, extra * extra);
  VectorXd out = (factor * sigma.array()).square() + extra * extra;
  if (out.maxCoeff() <= kSameVariance * out.minCoeff()) out.setConstant(out.mean());
  return out;
}

SampleScatter scatter_by_squares(const VectorXd& residual, const VectorXd& sigma, double freedom) {
  const ArrayXd squares = residual.array().square();
  if (sigma.size() == 0) return {0.0, std::sqrt(squares.sum() / freedom)};
  const ArrayXd stated = sigma.array().square();
  double sum = (squares / stated).sum();
  if (sum <= freedom) return {std::sqrt(sum / freedom), 0.0};
  // Newton's iteration on 1 / sum = 1 / freedom: concave in the extra variance, so that it comes
  // from one side, and a straight line if all sigmas are the same.
  double extra = 0.0;
  for (int i = 0; i < kIterations; ++i) {
    const ArrayXd variance = stated + extra;
    sum = (squares / variance).sum();
    const double slope = (squares / variance.square()).sum();
    const double step = sum / slope * (sum / freedom - 1.0);
    extra += std::max(step, 0.0);
    if (!(step > kStep * extra)) break;
  }
  return {1.0, std::sqrt(extra)};
}

SampleScatter scatter_by_median(const VectorXd& residual, const VectorXd& sigma) {
  const ArrayXd size = residual.array().abs();
  if (sigma.size() == 0) return {0.0, median(size) / kMedianOfNormal};
  const double in_sigmas = median(size / sigma.array()) / kMedianOfNormal;
  if (in_sigmas <= 1.0) return {in_sigmas, 0.0};
  double low = 0.0;
  double high = median(size) / kMedianOfNormal;  // without the sigmas it would be all
  for (int i = 0; i < kHalvings; ++i) {
    const double extra = 0.5 * (low + high);
    const bool more =
        median(size / (sigma.array().square() + extra * extra).sqrt()) > kMedianOfNormal;
    (more ? low : high) = extra;
  }
  return {1.0, high};
}

}  // namespace twang
