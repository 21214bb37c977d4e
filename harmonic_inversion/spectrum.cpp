// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/spectrum.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "harmonic_inversion/fourier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

constexpr std::size_t kMinSamples = 8;
constexpr std::size_t kPadding = 4;

/// Linear interpolation of (t, y) onto an even grid of as many samples.
Eigen::VectorXd interpolate_evenly(const std::vector<double>& t,
                                   const std::vector<double>& y,
                                   double step_s) {
  const std::size_t count = t.size();
  Eigen::VectorXd out(static_cast<Eigen::Index>(
      std::max<long>(std::lround((t.back() - t.front()) / step_s) + 1, static_cast<long>(2))));
  std::size_t right = 1;
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    const double time = t.front() + static_cast<double>(i) * step_s;
    while (right + 1 < count && t[right] < time) ++right;
    const double part = std::clamp((time - t[right - 1]) / (t[right] - t[right - 1]), 0.0, 1.0);
    out(i) = (1.0 - part) * y[right - 1] + part * y[right];
  }
  return out;
}

}  // namespace

Spectrum amplitude_spectrum(const Trace& trace,
                            const Channel& channel,
                            double start_s,
                            double end_s) {
  std::vector<double> t;
  std::vector<double> y;
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    if (trace.time_s[i] < start_s || trace.time_s[i] > end_s) continue;
    if (!std::isfinite(channel.values[i])) continue;
    t.push_back(trace.time_s[i]);
    y.push_back(channel.values[i]);
  }
  if (t.size() < kMinSamples) {
    throw InputError(fmt::format(
        "channel {}: {} finite samples between {:.6g} and {:.6g} s, expected at least {}",
        channel.name,
        t.size(),
        start_s,
        end_s,
        kMinSamples));
  }
  std::vector<double> steps;
  for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
  std::nth_element(
      steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  // The median step, stretched so that the grid ends on the last sample.
  const double span = t.back() - t.front();
  const double step = span / std::max(1.0, std::round(span / steps[steps.size() / 2]));

  Eigen::VectorXd even = interpolate_evenly(t, y, step);
  even.array() -= even.mean();
  const auto n = even.size();
  double gain = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double window =
        0.5 - 0.5 * std::cos(kTwoPi * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
    even(i) *= window;
    gain += window;
  }
  const std::size_t length = fast_length(kPadding * static_cast<std::size_t>(n));
  const auto transform = fourier_transform(even, length);
  Spectrum out;
  for (std::size_t k = 0; k < transform.size(); ++k) {
    const bool one_sided = k == 0 || 2 * k == length;
    out.frequency_hz.push_back(static_cast<double>(k) / (static_cast<double>(length) * step));
    out.amplitude.push_back((one_sided ? 1.0 : 2.0) * std::abs(transform[k]) / gain);
  }
  return out;
}

Spectrum model_spectrum(const Trace& trace, const InversionResult& inversion) {
  const std::string& name = inversion.channel_names.front();
  const Channel* channel = trace.find(name);
  if (channel == nullptr)
    throw InputError(fmt::format("column {} is not in the trace whose model is drawn", name));
  const Channel* later = trace.time_offset_of(name);
  Channel model{name, {}};
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    const double time = trace.time_s[i] + (later == nullptr ? 0.0 : later->values[i]);
    model.values.push_back(std::isfinite(channel->values[i]) ? inversion.evaluate(0, time) : kNaN);
  }
  return amplitude_spectrum(trace, model, inversion.time_origin_s, inversion.time_end_s);
}

}  // namespace twang
