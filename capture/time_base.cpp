// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/time_base.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace twang {
namespace {

// Rounding of the arithmetic, beside a tick of rounding in the file [ticks].
constexpr double kTickSlack = 1e-3;

bool is_rate(const std::optional<double>& fps) { return fps && std::isfinite(*fps) && *fps > 0.0; }

void check_order(const std::vector<double>& stamps) {
  std::size_t last = stamps.size();
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (std::isnan(stamps[i])) continue;
    if (last < stamps.size() && !(stamps[i] > stamps[last])) {
      throw InputError(
          fmt::format("frame {} is stamped {:.6f} s, must be later than frame {} at {:.6f} s",
                      i + 1,
                      stamps[i],
                      last + 1,
                      stamps[last]));
    }
    last = i;
  }
}

/// Frames elapsed since the first, by the stamps and a rate; nothing if they do not fit it.
std::optional<std::vector<double>> count_frames(const std::vector<double>& stamps,
                                                double tick_s,
                                                double fps) {
  const double allowed = tick_s * (1.0 + kTickSlack);
  std::vector<double> counts(stamps.size(), 0.0);
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double elapsed = stamps[i] - stamps[0];
    counts[i] = std::round(elapsed * fps);
    if (counts[i] <= counts[i - 1] || std::abs(elapsed - counts[i] / fps) > allowed) {
      return std::nullopt;
    }
  }
  return counts;
}

/// Frames elapsed by the stamps alone: each step is the nearest whole number of usual steps.
std::vector<double> count_frames(const std::vector<double>& stamps) {
  std::vector<double> steps(stamps.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = stamps[i + 1] - stamps[i];
  std::vector<double> sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  std::vector<double> counts(stamps.size(), 0.0);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    counts[i + 1] = counts[i] + std::max(1.0, std::round(steps[i] / *middle));
  }
  return counts;
}

/// Rate of the line through the stamps: slope of counts over time [1/s].
double slope_rate(const std::vector<double>& stamps, const std::vector<double>& counts) {
  const auto n = static_cast<double>(stamps.size());
  const double mean_time = std::accumulate(stamps.begin(), stamps.end(), 0.0) / n;
  const double mean_count = std::accumulate(counts.begin(), counts.end(), 0.0) / n;
  double time_by_count = 0.0;
  double count_by_count = 0.0;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const double dc = counts[i] - mean_count;
    time_by_count += dc * (stamps[i] - mean_time);
    count_by_count += dc * dc;
  }
  return count_by_count / time_by_count;
}

/// Puts a stamp where there is none, evenly between its neighbours, and at the usual step outside.
std::vector<double> fill_stamps(std::vector<double> stamps, std::optional<double> rate) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (!std::isnan(stamps[i])) known.push_back(i);
  }
  if (known.size() == stamps.size()) return stamps;
  if (known.size() < 2 && !rate) {
    throw InputError("the film has neither stamps nor a frame rate, must have one of them");
  }
  const auto distance = [](std::size_t a, std::size_t b) {
    return static_cast<double>(b) - static_cast<double>(a);
  };
  const double step =
      rate ? 1.0 / *rate
           : (stamps[known.back()] - stamps[known.front()]) / distance(known.front(), known.back());
  const std::size_t first = known.empty() ? 0 : known.front();
  const double origin = known.empty() ? 0.0 : stamps[first];
  std::size_t next = 0;  // of known, the first at or behind i
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    while (next < known.size() && known[next] < i) ++next;
    if (next < known.size() && known[next] == i) continue;
    if (next == 0) {
      stamps[i] = origin + step * distance(first, i);
    } else if (next == known.size()) {
      stamps[i] = stamps[known.back()] + step * distance(known.back(), i);
    } else {
      const std::size_t a = known[next - 1];
      const std::size_t b = known[next];
      stamps[i] = stamps[a] + (stamps[b] - stamps[a]) * distance(a, i) / distance(a, b);
    }
  }
  return stamps;
}

}  // namespace

TimeBase correct_time_base(const std::vector<double>& stamps_s,
                           double tick_s,
                           std::optional<double> declared_fps,
                           std::optional<StatedRate> stated) {
  if (stated && !is_rate(stated->fps)) {
    throw InputError(
        fmt::format("{}: capture rate is {}, must be > 0", stated->source, stated->fps));
  }
  if (stamps_s.empty()) throw InputError("the film has no frames, must have at least one");
  check_order(stamps_s);
  std::optional<double> declared = is_rate(declared_fps) ? declared_fps : std::nullopt;
  std::optional<double> any_rate = declared;
  if (!any_rate && stated) any_rate = stated->fps;
  const bool stamped = std::any_of(
      stamps_s.begin(), stamps_s.end(), [](double stamp) { return !std::isnan(stamp); });
  const std::vector<double> stamps = fill_stamps(stamps_s, any_rate);

  TimeBase result;
  TimeBaseSummary& summary = result.summary;
  summary.frames = static_cast<int>(stamps.size());
  // Without stamps the film is as regular as its rate; a file without a rate lends the stated one.
  if (!stamped || stamps.size() == 1) declared = any_rate;
  std::optional<std::vector<double>> counts;
  if (declared) counts = count_frames(stamps, tick_s, *declared);
  const bool regular = counts.has_value();
  if (!regular) {
    if (stamps.size() == 1) {
      throw InputError("the film has one frame and no frame rate, must have a rate");
    }
    counts = count_frames(stamps);
  }
  summary.file_fps = regular ? *declared : slope_rate(stamps, *counts);
  summary.capture_fps = stated ? stated->fps : summary.file_fps;
  summary.source = stated ? stated->source : regular ? "container" : "stamps";
  summary.gaps = static_cast<int>(std::lround(counts->back())) - (summary.frames - 1);

  const double stretch = summary.file_fps / summary.capture_fps;
  result.time_s.resize(stamps.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    result.time_s[i] =
        regular ? (*counts)[i] / summary.capture_fps : (stamps[i] - stamps[0]) * stretch;
  }
  return result;
}

}  // namespace twang
