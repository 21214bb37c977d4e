// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace twang {

/// Of two positive numbers, the larger over the smaller: >= 1.
[[nodiscard]] inline double ratio_of(double a, double b) { return a > b ? a / b : b / a; }

}  // namespace twang
