// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/repeat_scatter.hpp"

#include <cmath>

namespace twang {

double relative_standard_error(const std::vector<double>& values) {
  if (values.size() < 2) return 0.0;
  const auto count = static_cast<double>(values.size());
  double mean = 0.0;
  for (const double value : values) mean += value / count;
  double variance = 0.0;
  for (const double value : values) variance += (value - mean) * (value - mean) / (count - 1.0);
  return std::sqrt(variance / count) / std::abs(mean);
}

}  // namespace twang
