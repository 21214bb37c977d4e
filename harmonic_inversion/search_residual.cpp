// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "harmonic_inversion/fourier.hpp"
#include "harmonic_inversion/propose_poles.hpp"

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Neighbouring decays of the search differ by this factor: the gain falls by under a tenth
/// between.
constexpr double kDecayFactor = 2.5;
/// Grid cells per usual step when the stamps fit no even grid.
constexpr double kUnevenOversampling = 4.0;
/// A decay constant of this many samples is the fastest searched for.
constexpr double kFastestDecaySamples = 2.0;

/// Residual times exponential window, each sample in its nearest cell; and the window's energy.
struct WindowedResidual {
  VectorXd cells;
  double energy = 0.0;
};

WindowedResidual apply_window(const SampleSeries& residual, double decay_per_s, double cell_s) {
  const VectorXd& t = residual.time_s;
  const auto length = static_cast<Index>(std::lround(t(t.size() - 1) / cell_s)) + 1;
  WindowedResidual out{VectorXd::Zero(length), 0.0};
  for (Index i = 0; i < t.size(); ++i) {
    const double window = std::exp(-decay_per_s * t(i));
    out.cells(static_cast<Index>(std::lround(t(i) / cell_s))) += window * residual.value(i);
    out.energy += window * window;
  }
  return out;
}

bool is_excluded(const DampedPole& pole,
                 const std::vector<DampedPole>& excluded,
                 double duration_s) {
  return std::any_of(excluded.begin(), excluded.end(), [&](const DampedPole& other) {
    const double width = std::max(std::abs(other.decay_per_s) / kTwoPi, 0.75 / duration_s);
    return std::abs(pole.frequency_hz - other.frequency_hz) < width;
  });
}

}  // namespace

std::vector<PoleCandidate> search_residual(const std::vector<SampleSeries>& residuals,
                                           double step_s,
                                           const Band& band_hz,
                                           const std::vector<DampedPole>& excluded,
                                           int count) {
  double duration = 0.0;
  bool even = true;
  for (const SampleSeries& residual : residuals) {
    duration = std::max(duration, residual.time_s(residual.time_s.size() - 1));
    even = even && on_even_grid(residual, step_s).has_value();
  }
  const double cell = even ? step_s : step_s / kUnevenOversampling;
  const auto length = fast_length(2 * (static_cast<std::size_t>(std::lround(duration / cell)) + 1));
  const double bin_hz = 1.0 / (static_cast<double>(length) * cell);
  const auto first = static_cast<std::size_t>(std::ceil(band_hz.low_hz / bin_hz));
  const auto last = static_cast<std::size_t>(band_hz.high_hz / bin_hz);

  std::vector<PoleCandidate> peaks;
  for (double d = 0.3 / duration; d < 1.0 / (kFastestDecaySamples * step_s); d *= kDecayFactor) {
    std::vector<double> gain(length / 2 + 1, 0.0);
    for (const SampleSeries& residual : residuals) {
      const WindowedResidual windowed = apply_window(residual, d, cell);
      const auto spectrum = fourier_transform(windowed.cells, length);
      for (std::size_t k = 0; k < gain.size(); ++k) {
        gain[k] += std::norm(spectrum[k]) / (0.5 * windowed.energy);
      }
    }
    for (std::size_t k = std::max<std::size_t>(first, 1); k < last && k + 1 < gain.size(); ++k) {
      if (gain[k] < gain[k - 1] || gain[k] < gain[k + 1]) continue;
      const DampedPole pole{static_cast<double>(k) * bin_hz, d};
      if (d > kTwoPi * pole.frequency_hz || is_excluded(pole, excluded, duration)) continue;
      peaks.push_back({pole, gain[k], 0.0});
    }
  }
  std::sort(peaks.begin(), peaks.end(), [](const PoleCandidate& a, const PoleCandidate& b) {
    return a.amplitude > b.amplitude;
  });
  std::vector<PoleCandidate> out;
  for (const PoleCandidate& peak : peaks) {
    if (static_cast<int>(out.size()) >= count) break;
    std::vector<DampedPole> taken;
    for (const PoleCandidate& other : out) taken.push_back(other.pole);
    if (!is_excluded(peak.pole, taken, duration)) out.push_back(peak);
  }
  return out;
}

}  // namespace twang
