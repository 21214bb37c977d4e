// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/join_repeats.hpp"

#include "core/constants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

constexpr double kSameInstant_s = 1e-6;

bool inside(const TraceWindow& window, double time_s) {
  return time_s >= window.start_s && time_s <= window.end_s;
}

std::vector<double> merged_times(const std::vector<TraceWindow>& windows) {
  std::vector<double> times;
  for (const TraceWindow& window : windows) {
    for (const double time : window.trace->time_s) {
      if (inside(window, time)) times.push_back(time - window.start_s);
    }
  }
  std::sort(times.begin(), times.end());
  const auto end = std::unique(
      times.begin(), times.end(), [](double a, double b) { return b - a < kSameInstant_s; });
  times.erase(end, times.end());
  return times;
}

}  // namespace

Trace join_repeats(const std::vector<TraceWindow>& windows) {
  Trace joint;
  joint.time_s = merged_times(windows);
  for (std::size_t repeat = 0; repeat < windows.size(); ++repeat) {
    const TraceWindow& window = windows[repeat];
    for (const std::string& column : window.columns) {
      const Channel* source = window.trace->find(column);
      Channel target{fmt::format("{}:{}", repeat + 1, column),
                     std::vector<double>(joint.num_samples(), kNaN)};
      for (std::size_t i = 0; i < window.trace->num_samples(); ++i) {
        const double time = window.trace->time_s[i];
        if (!inside(window, time)) continue;
        const auto slot = std::lower_bound(
            joint.time_s.begin(), joint.time_s.end(), time - window.start_s - kSameInstant_s);
        target.values[static_cast<std::size_t>(slot - joint.time_s.begin())] = source->values[i];
      }
      joint.channels.push_back(std::move(target));
    }
  }
  return joint;
}

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
