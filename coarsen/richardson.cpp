// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/richardson.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace twang {
namespace {

// Corners and clamps make the solution singular, which caps the order of hex20 (4 in lambda for a
// smooth one) at 2 or less.
constexpr double kAssumedOrder = 2.0;
constexpr double kLowestOrder = 1.0;
constexpr double kHighestOrder = 6.0;
// hex20 with one cell through the thickness errs by 1 to 3 % in lambda; one sigma, generously.
constexpr double kSigmaOfOneMesh = 0.05;
// No mesh of a printed part is known better than this.
constexpr double kSmallestSigma = 1e-4;

}  // namespace

RichardsonLimit richardson_limit(const std::vector<double>& lambdas_per_s2) {
  assert(!lambdas_per_s2.empty());
  const std::size_t n = lambdas_per_s2.size();
  const double finest = lambdas_per_s2.back();
  if (n == 1) return {finest, kSigmaOfOneMesh, 0.0, false};

  const double last_change = lambdas_per_s2[n - 2] - finest;
  RichardsonLimit limit;
  limit.order = kAssumedOrder;
  bool shrinking = true;
  if (n >= 3 && last_change != 0.0) {
    const double ratio = (lambdas_per_s2[n - 3] - lambdas_per_s2[n - 2]) / last_change;
    const double order = ratio > 0.0 ? std::log2(ratio) : 0.0;
    shrinking = std::abs(ratio) > 1.0;
    limit.order_observed = order >= kLowestOrder && order <= kHighestOrder;
    if (limit.order_observed) {
      limit.order = order;
    } else if (ratio > 1.0) {
      limit.order = std::clamp(order, kLowestOrder, kHighestOrder);
    }
  }
  const double correction = last_change / (std::exp2(limit.order) - 1.0);
  limit.lambda_per_s2 = finest - correction;
  const double spread = !shrinking             ? last_change
                        : limit.order_observed ? 0.5 * correction
                                               : correction;
  limit.relative_sigma = std::max(std::abs(spread) / limit.lambda_per_s2, kSmallestSigma);
  return limit;
}

}  // namespace twang
