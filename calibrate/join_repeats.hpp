// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/trace.hpp"

#include <string>
#include <vector>

namespace twang {

/// A stretch of one trace, from the first sample of its free motion to the last one used.
struct TraceWindow {
  const Trace* trace = nullptr;
  std::vector<std::string> columns;
  double start_s = 0.0;
  double end_s = 0.0;
};

/// Lays repeats over each other: every window starts at time 0, channels are named
/// `<repeat>:<column>`, and a repeat without a sample at a time of another holds nan there. Stamps
/// closer than a microsecond count as one.
[[nodiscard]] Trace join_repeats(const std::vector<TraceWindow>& windows);

/// Relative standard error of the mean of `values`, (standard deviation / sqrt(n)) / mean; 0 with
/// fewer than two.
[[nodiscard]] double relative_standard_error(const std::vector<double>& values);

}  // namespace twang
