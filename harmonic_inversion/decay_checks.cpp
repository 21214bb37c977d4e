// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/decay_checks.hpp"

#include "core/error.hpp"
#include "core/text.hpp"
#include "harmonic_inversion/checked_signal.hpp"
#include "harmonic_inversion/evaluate_modes.hpp"
#include "harmonic_inversion/logarithmic_decrement.hpp"
#include "harmonic_inversion/morlet_ridge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kJointSigmas = 3.0;   // beyond which a check disagrees
constexpr double kRelative = 0.02;     // of d, and beyond that too
constexpr double kLeastNoise = 1e-10;  // of the amplitude

constexpr double kDense = 48.0;  // samples a period; of more than twice as many, means

/// The samples as columns: time, value, mode alone, residual.
using Rows = Eigen::MatrixX4d;

/// Means over equal stretches of time where there are far more samples than a period needs; they
/// shrink a sinusoid by a constant factor.
Rows thinned(Rows rows, double period_s) {
  const Index count = rows.rows();
  if (count < 2) return rows;
  const double span_s = rows(count - 1, 0) - rows(0, 0);
  const double step_s = span_s / static_cast<double>(count - 1);
  const double each = std::floor(period_s / (kDense * step_s));
  if (each < 2.0) return rows;
  Rows out(count, 4);
  Index filled = 0;
  Index first = 0;
  const auto stretch = [&](Index i) {
    return std::floor((rows(i, 0) - rows(0, 0)) / (each * step_s) + 0.5 / each);
  };
  for (Index i = 1; i <= count; ++i) {
    if (i < count && stretch(i) == stretch(first)) continue;
    out.row(filled++) = rows.middleRows(first, i - first).colwise().mean();
    first = i;
  }
  return out.topRows(filled);
}

/// Samples in the window of `result`, from its origin on: time and value.
Eigen::MatrixX2d samples_of(const Trace& trace,
                            const Channel& channel,
                            const InversionResult& result,
                            std::size_t c) {
  const Channel* later = trace.time_offset_of(channel.name);
  Eigen::MatrixX2d samples(static_cast<Index>(trace.num_samples()), 2);
  Index count = 0;
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    if (trace.time_s[i] < result.origin_s(c) || trace.time_s[i] > result.time_end_s) continue;
    const double time = trace.time_s[i] + (later == nullptr ? 0.0 : later->values[i]);
    const double y = channel.values[i];
    if (!std::isfinite(y) || !std::isfinite(time)) continue;
    samples.row(count++) << time - result.origin_s(c), y;
  }
  samples.conservativeResize(count, 2);
  return samples;
}

/// A result with its first mode alone, without offset and drift, or with all else.
InversionResult mode_of(const InversionResult& result) {
  InversionResult out = result;
  out.modes.resize(1);
  std::fill(out.offsets.begin(), out.offsets.end(), 0.0);
  std::fill(out.drifts_per_s.begin(), out.drifts_per_s.end(), 0.0);
  return out;
}

InversionResult rest_of(const InversionResult& result) {
  InversionResult out = result;
  out.modes.erase(out.modes.begin());
  return out;
}

CheckedSignal prepare(const Trace& trace,
                      const Channel& channel,
                      const InversionResult& result,
                      std::size_t c) {
  CheckedSignal signal;
  signal.modes = result.modes;
  signal.channel = c;
  const Eigen::MatrixX2d samples = samples_of(trace, channel, result, c);
  const Index count = samples.rows();
  Rows rows(count, 4);
  rows.leftCols<2>() = samples;
  rows.col(2) = samples.col(1) - evaluate_modes(rest_of(result), c, samples.col(0));
  rows.col(3) = rows.col(2) - evaluate_modes(mode_of(result), c, samples.col(0));
  rows.col(1).array() -= result.offsets[c] + result.drifts_per_s[c] * samples.col(0).array();
  const double unknowns = 2.0 + 4.0 * static_cast<double>(result.modes.size());
  const double left = std::max(1.0, static_cast<double>(count) - unknowns);
  const double widening = std::sqrt(static_cast<double>(count) / left);
  rows = thinned(std::move(rows), 1.0 / signal.mode().frequency_hz);
  signal.time_s = rows.col(0);
  signal.value = rows.col(1);
  signal.mode_alone = rows.col(2);
  const double rms = rows.rows() > 0
                         ? std::sqrt(rows.col(3).squaredNorm() / static_cast<double>(rows.rows()))
                         : 0.0;
  signal.noise = std::max(rms * widening, kLeastNoise * signal.amplitude());
  return signal;
}

}  // namespace

std::vector<DecayCheck> check_decay(const Trace& trace,
                                    const std::string& channel,
                                    const InversionResult& result,
                                    std::size_t channel_index) {
  const Channel* samples = trace.find(channel);
  if (samples == nullptr)
    throw InputError(fmt::format("column {} is not in the trace whose decay is checked", channel));
  if (channel_index >= result.channel_names.size()) {
    throw InputError(fmt::format("channel_index is {}, must be below {}, the number of channels",
                                 channel_index,
                                 result.channel_names.size()));
  }
  if (!result.usable()) return {};
  const CheckedSignal signal = prepare(trace, *samples, result, channel_index);
  std::vector<DecayCheck> checks = {logarithmic_decrement(signal), morlet_ridge(signal)};
  for (DecayCheck& check : checks) check.channel = channel;
  return checks;
}

std::vector<DecayCheck> check_decay(const Trace& trace, const InversionResult& result) {
  if (!result.usable()) return {};
  const std::vector<SinusoidInChannel>& parts = result.modes.front().channels;
  std::size_t best = 0;
  double best_ratio = -1.0;
  for (std::size_t c = 0; c < parts.size(); ++c) {
    const double sigma = parts[c].amplitude_sigma;
    const double ratio = sigma > 0.0 ? parts[c].amplitude / sigma : parts[c].amplitude;
    if (ratio > best_ratio) {
      best_ratio = ratio;
      best = c;
    }
  }
  return check_decay(trace, result.channel_names[best], result, best);
}

std::string disagreement(const DecayCheck& check, const DampedSinusoid& mode) {
  if (!check.usable()) return {};
  const double difference = std::abs(check.decay_per_s - mode.decay_per_s);
  const double fit_sigma = std::isfinite(mode.decay_sigma_per_s) ? mode.decay_sigma_per_s : 0.0;
  const double joint = std::hypot(check.decay_sigma_per_s, fit_sigma);
  if (difference <= kJointSigmas * joint || difference <= kRelative * std::abs(mode.decay_per_s))
    return {};
  return fmt::format(
      "{}: the {} gives a decay of {} ± {} 1/s, the fit {} ± {} 1/s; the motion may not be a pure "
      "exponential, or the noise not white.",
      check.channel,
      check.method,
      rounded_text(check.decay_per_s, 4),
      rounded_text(check.decay_sigma_per_s, 2),
      rounded_text(mode.decay_per_s, 4),
      rounded_text(mode.decay_sigma_per_s, 2));
}

InversionResult with_decay_checks(InversionResult result, const Trace& trace) {
  result.decay_checks = check_decay(trace, result);
  for (const DecayCheck& check : result.decay_checks) {
    std::string sentence = disagreement(check, result.modes.front());
    if (!sentence.empty()) result.notes.push_back(std::move(sentence));
  }
  return result;
}

}  // namespace twang
