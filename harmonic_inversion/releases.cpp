// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/releases.hpp"

#include "core/error.hpp"
#include "harmonic_inversion/release.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

constexpr double kSameMode = 0.2;  // of the frequency, between a mode of all and of one

/// The rows from `from_s` to `to_s`.
Trace cut(const Trace& trace, double from_s, double to_s) {
  const auto first = std::lower_bound(trace.time_s.begin(), trace.time_s.end(), from_s);
  const auto last = std::upper_bound(first, trace.time_s.end(), to_s);
  const auto begin = first - trace.time_s.begin();
  const auto end = last - trace.time_s.begin();
  Trace out;
  out.time_s.assign(first, last);
  for (const Channel& channel : trace.channels) {
    out.channels.push_back(
        {channel.name, {channel.values.begin() + begin, channel.values.begin() + end}});
  }
  return out;
}

double standard_deviation(const std::vector<double>& values) {
  if (values.size() < 2) return kNaN;
  double mean = 0.0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

}  // namespace

std::vector<Trace> cut_at_releases(const Trace& trace,
                                   const std::vector<std::string>& channels,
                                   const InversionOptions& options) {
  options.check();
  for (const std::string& name : channels) {
    if (trace.find(name) == nullptr) {
      throw InputError(fmt::format("column {} is not in the trace", name));
    }
  }
  if (trace.num_samples() == 0) throw InputError("the trace is empty, expected at least 8 samples");
  const double last = std::min(options.end_s.value_or(kInfinity), trace.time_s.back());
  double from = std::max(options.start_s.value_or(-kInfinity), trace.time_s.front());
  if (!(from <= last)) {
    throw InputError(
        fmt::format("nothing lies between the start, {:.6g} s, and the end, {:.6g} s, "
                    "of what is looked at, expected at least 8 samples",
                    from,
                    last));
  }
  std::vector<Trace> out;
  for (;;) {
    const FreeMotion motion = find_free_motion_until(trace, channels, from, last);
    // What is left after the last release may hold none.
    if (motion.release_s || out.empty()) out.push_back(cut(trace, from, motion.end_s));
    if (!motion.ends_early || !(motion.end_s > from)) break;
    from = motion.end_s;
  }
  return out;
}

const DampedSinusoid* RepeatedInversion::mode_alone(std::size_t n) const {
  if (joint.modes.empty()) return nullptr;
  const double wanted = joint.modes.front().frequency_hz;
  const DampedSinusoid* nearest = nullptr;
  for (const DampedSinusoid& mode : alone[n].modes) {
    const double away = std::abs(mode.frequency_hz - wanted);
    if (away > kSameMode * wanted) continue;
    if (nearest == nullptr || away < std::abs(nearest->frequency_hz - wanted)) nearest = &mode;
  }
  return nearest;
}

RepeatedInversion relate_repeats(InversionResult joint, std::vector<InversionResult> alone) {
  RepeatedInversion out;
  out.joint = std::move(joint);
  out.alone = std::move(alone);
  std::vector<double> frequencies;
  std::vector<double> decays;
  for (std::size_t n = 0; n < out.alone.size(); ++n) {
    const DampedSinusoid* mode = out.mode_alone(n);
    if (mode == nullptr) continue;
    frequencies.push_back(mode->frequency_hz);
    decays.push_back(mode->decay_per_s);
  }
  out.frequency_scatter_hz = standard_deviation(frequencies);
  out.decay_scatter_per_s = standard_deviation(decays);
  return out;
}

RepeatedInversion compare_repeats(const std::vector<Trace>& traces,
                                  const std::vector<std::string>& channels,
                                  const InversionOptions& options) {
  std::vector<InversionResult> alone;
  for (const Trace& trace : traces) alone.push_back(invert_harmonics(trace, channels, options));
  return relate_repeats(invert_repeats(traces, channels, options), std::move(alone));
}

}  // namespace twang
