// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/window_stability.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace twang {
namespace {

struct Window {
  double start_s = 0.0;
  double end_s = 0.0;
};

/// Windows that lose a fair part of the data, in decay times of the sinusoid so that early and late
/// mean the same for all.
std::vector<Window> narrower_windows(const InversionResult& whole) {
  const double duration_s = whole.time_end_s - whole.time_origin_s;
  const double decay_per_s = std::max(whole.modes.front().decay_per_s, 1.0 / duration_s);
  std::vector<Window> windows;
  for (const double decay_times : {0.35, 0.7}) {
    windows.push_back({whole.time_origin_s + decay_times / decay_per_s, whole.time_end_s});
  }
  windows.push_back(
      {whole.time_origin_s, whole.time_origin_s + std::min(2.0 / decay_per_s, 0.7 * duration_s)});
  return windows;
}

/// The part of a difference that the noise of both estimates does not explain.
double excess(double difference, double sigma_part, double sigma_whole) {
  const double explained = std::max(0.0, sigma_part * sigma_part - sigma_whole * sigma_whole);
  return std::sqrt(std::max(0.0, difference * difference - explained));
}

}  // namespace

WindowStability window_stability(const Trace& trace,
                                 const std::vector<std::string>& columns,
                                 const InversionResult& whole,
                                 const InversionOptions& options) {
  WindowStability stability;
  if (!whole.usable()) return stability;
  constexpr double kFewestPeriods = 4.0;  // a narrower window says nothing about decay
  constexpr double kSameSinusoid = 0.05;  // relative, of frequency
  const DampedSinusoid& mode = whole.modes.front();
  for (const Window& window : narrower_windows(whole)) {
    if ((window.end_s - window.start_s) * mode.frequency_hz < kFewestPeriods) continue;
    InversionOptions narrower = options;
    narrower.start_s = window.start_s;
    narrower.end_s = window.end_s;
    narrower.progress = {};
    InversionResult part;
    try {
      part = invert_harmonics(trace, columns, narrower);
    } catch (const InputError&) {
      continue;  // too few samples are left
    }
    if (!part.usable()) continue;
    const DampedSinusoid& found = part.modes.front();
    if (std::abs(found.frequency_hz / mode.frequency_hz - 1.0) > kSameSinusoid) continue;
    ++stability.windows;
    stability.frequency_spread_hz = std::max(stability.frequency_spread_hz,
                                             excess(found.frequency_hz - mode.frequency_hz,
                                                    found.frequency_sigma_hz,
                                                    mode.frequency_sigma_hz));
    stability.decay_spread_per_s = std::max(
        stability.decay_spread_per_s,
        excess(
            found.decay_per_s - mode.decay_per_s, found.decay_sigma_per_s, mode.decay_sigma_per_s));
  }
  return stability;
}

DampedSinusoid widened(DampedSinusoid sinusoid, const WindowStability& stability) {
  sinusoid.frequency_sigma_hz =
      std::hypot(sinusoid.frequency_sigma_hz, stability.frequency_spread_hz);
  sinusoid.decay_sigma_per_s = std::hypot(sinusoid.decay_sigma_per_s, stability.decay_spread_per_s);
  return sinusoid;
}

}  // namespace twang
