// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace twang {

/// Relative standard error of the mean of `values`, (standard deviation / sqrt(n)) / mean; 0 with
/// fewer than two.
[[nodiscard]] double relative_standard_error(const std::vector<double>& values);

}  // namespace twang
