// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/inversion_window.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "harmonic_inversion/release.hpp"
#include "harmonic_inversion/stated_sigmas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace twang {
namespace {

constexpr std::size_t kMinSamples = 8;

void check_channels(const Trace& trace, const std::vector<std::string>& channels) {
  if (trace.num_samples() == 0) throw InputError("the trace is empty, expected at least 8 samples");
  if (channels.empty()) throw InputError("no column was named, expected at least one to invert");
  for (const std::string& name : channels) {
    const Channel* channel = trace.find(name);
    if (channel == nullptr) {
      std::string known;
      for (const Channel& other : trace.channels) known += (known.empty() ? "" : ", ") + other.name;
      throw InputError(
          fmt::format("column {} is not in the trace, expected one of: {}", name, known));
    }
    if (Trace::num_finite(*channel) < kMinSamples) {
      throw InputError(fmt::format("column {} has {} finite samples, expected at least {}",
                                   name,
                                   Trace::num_finite(*channel),
                                   kMinSamples));
    }
  }
}

/// The free motion, or what the options say of it; it ends where the next pull begins, though the
/// end given be later.
FreeMotion choose_span(const Trace& trace,
                       const std::vector<std::string>& channels,
                       const InversionOptions& options) {
  const double first = trace.time_s.front();
  const double last = trace.time_s.back();
  const double wanted_end = options.end_s.value_or(last);
  FreeMotion motion = find_free_motion_until(trace, channels, first, wanted_end);
  if (!options.start_s) return motion;
  // Walk from release to release until one is not over before the start.
  while (motion.ends_early && motion.end_s <= *options.start_s) {
    motion = find_free_motion_until(trace, channels, motion.end_s, wanted_end);
  }
  if (motion.release_s && *motion.release_s >= *options.start_s) {
    motion.note = fmt::format(
        "still at rest or held at the start given, {:.6g} s: {}", *options.start_s, motion.note);
    return motion;
  }
  const std::string note =
      options.end_s && motion.ends_early
          ? fmt::format(
                "free motion is taken to {:.6g} s, where the next pull begins, before the "
                "end given, {:.6g} s",
                motion.end_s,
                wanted_end)
          : "";
  return {*options.start_s, motion.end_s, std::nullopt, false, note};
}

double median_step(const Trace& trace) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < trace.num_samples(); ++i) {
    steps.push_back(trace.time_s[i] - trace.time_s[i - 1]);
  }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// Samples of a channel, and the first and last row of the trace they are from.
struct CutSeries {
  SampleSeries series;
  double first_s = 0.0;
  double last_s = 0.0;
  std::string sigma_column;  ///< empty: the samples count alike
};

/// The finite samples of one channel in the rows within a span, each at its own time: that of its
/// row, and what the channel was sampled later.
/// @param sigma_column  empty: the trace's own
CutSeries cut(const Trace& trace,
              const std::string& name,
              const std::string& sigma_column,
              const FreeMotion& span) {
  const Channel& channel = *trace.find(name);
  const Channel* offset_s = trace.time_offset_of(name);
  const Channel* sigma = stated_sigmas(trace, channel, sigma_column);
  CutSeries result;
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    const double t = trace.time_s[i];
    const bool timed = offset_s == nullptr || std::isfinite(offset_s->values[i]);
    if (t >= span.start_s && t <= span.end_s && std::isfinite(channel.values[i]) && timed)
      rows.push_back(i);
  }
  if (rows.size() < kMinSamples) {
    throw InputError(fmt::format(
        "column {} has {} finite samples{} from {:.6g} to {:.6g} s, expected at least {}",
        name,
        rows.size(),
        sigma == nullptr ? "" : " with a number in " + sigma->name,
        span.start_s,
        span.end_s,
        kMinSamples));
  }
  result.first_s = trace.time_s[rows.front()];
  result.last_s = trace.time_s[rows.back()];
  SampleSeries& out = result.series;
  out.name = name;
  out.time_s.resize(static_cast<Eigen::Index>(rows.size()));
  out.value.resize(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    out.time_s(static_cast<Eigen::Index>(r)) =
        trace.time_s[rows[r]] + (offset_s == nullptr ? 0.0 : offset_s->values[rows[r]]);
    out.value(static_cast<Eigen::Index>(r)) = channel.values[rows[r]];
  }
  if (sigma == nullptr) return result;
  out.sigma.resize(out.value.size());
  for (std::size_t r = 0; r < rows.size(); ++r)
    out.sigma(static_cast<Eigen::Index>(r)) = sigma->values[rows[r]];
  if (out.sigma.maxCoeff() > out.sigma.minCoeff()) {
    result.sigma_column = sigma->name;
  } else {
    out.sigma.resize(0);  // all the same: the samples count alike
  }
  return result;
}

}  // namespace

InversionWindow choose_window(std::span<const Trace> traces,
                              const std::vector<std::string>& channels,
                              const InversionOptions& options) {
  if (traces.empty()) throw InputError("no trace was given, expected at least one");
  if (options.sigma_columns.size() > 1 && options.sigma_columns.size() != channels.size()) {
    throw InputError(
        fmt::format("{} columns are named for the standard deviations of {}, expected one for all "
                    "or one each",
                    options.sigma_columns.size(),
                    channels.size()));
  }
  InversionWindow out;
  out.num_traces = traces.size();
  for (std::size_t n = 0; n < traces.size(); ++n) {
    check_channels(traces[n], channels);
    KnownSamples known = without_unknown_sigmas(traces[n], channels, options.sigma_columns);
    const Trace& trace = known.trace ? *known.trace : traces[n];
    std::move(known.notes.begin(), known.notes.end(), std::back_inserter(out.notes));
    const FreeMotion span = choose_span(trace, channels, options);
    std::vector<SampleSeries> series;
    double origin = kInfinity;
    double end = -kInfinity;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      CutSeries part = cut(trace, channels[c], sigma_column_of(options.sigma_columns, c), span);
      origin = std::min(origin, part.first_s);
      end = std::max(end, part.last_s);
      out.sigma_columns.push_back(part.sigma_column);
      series.push_back(std::move(part.series));
    }
    for (SampleSeries& s : series) {
      s.time_s.array() -= origin;
      if (traces.size() > 1) s.name = fmt::format("{}:{}", n + 1, s.name);
      out.origins_s.push_back(origin);
      out.series.push_back(std::move(s));
    }
    if (n == 0) {
      out.end_s = end;
      out.release_s = span.release_s;
      out.step_s = median_step(traces[n]);
    }
    out.step_s = std::min(out.step_s, median_step(traces[n]));
    out.duration_s = std::max(out.duration_s, end - origin);
    if (!span.note.empty()) {
      out.notes.push_back(traces.size() > 1 ? fmt::format("Trace {}: {}.", n + 1, span.note)
                                            : fmt::format("Window: {}.", span.note));
    }
  }
  return out;
}

}  // namespace twang
