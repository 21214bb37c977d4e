// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/synthesize.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace twang {
namespace {

void require(bool fine, const char* field, double value, const char* range) {
  if (!fine)
    throw InputError(fmt::format("SynthesisOptions.{} is {}, must be {}", field, value, range));
}

}  // namespace

void SynthesisOptions::check() const {
  require(rate_hz > 0.0, "rate_hz", rate_hz, "> 0");
  require(duration_s >= 0.0, "duration_s", duration_s, ">= 0");
  require(noise_sigma >= 0.0, "noise_sigma", noise_sigma, ">= 0");
  require(jitter_s >= 0.0 && jitter_s < 0.5 / rate_hz, "jitter_s", jitter_s, "in [0, half a step)");
  require(held_s >= 0.0, "held_s", held_s, ">= 0");
  require(missing_part >= 0.0 && missing_part < 1.0, "missing_part", missing_part, "in [0, 1)");
}

Trace synthesize_sinusoids(const std::vector<SinusoidTruth>& sinusoids,
                           const SynthesisOptions& options) {
  options.check();
  std::mt19937 generator(options.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto count =
      static_cast<std::size_t>(std::floor(options.duration_s * options.rate_hz + 1e-9)) + 1;
  Trace trace;
  trace.channels.push_back({options.channel, {}});
  for (std::size_t i = 0; i < count; ++i) {
    double t = static_cast<double>(i) / options.rate_hz;
    if (options.jitter_s > 0.0) t += options.jitter_s * (2.0 * uniform(generator) - 1.0);
    const double since_release = options.held_s > 0.0 ? std::max(t - options.held_s, 0.0) : t;
    double value = options.offset + options.drift_per_s * t;
    for (const SinusoidTruth& s : sinusoids) {
      value += s.amplitude * std::exp(-s.decay_per_s * since_release) *
               std::sin(kTwoPi * s.frequency_hz * since_release + s.phase_rad);
    }
    if (options.noise_sigma > 0.0) value += options.noise_sigma * normal(generator);
    if (options.missing_part > 0.0 && uniform(generator) < options.missing_part) value = kNaN;
    trace.time_s.push_back(t);
    trace.channels.front().values.push_back(value);
  }
  return trace;
}

}  // namespace twang
