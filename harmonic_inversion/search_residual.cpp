// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "harmonic_inversion/fourier.hpp"
#include "harmonic_inversion/propose_poles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

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

/// An exponential window ends where it has fallen to e^-this.
constexpr double kWindowEnd = 16.0;
/// Shorter windows are transformed at the longest length over a power of this.
constexpr std::size_t kLengthFactor = 64;
/// Peaks that are kept while the search goes on, and those of which there are enough.
constexpr std::size_t kManyPeaks = 4096;
constexpr std::size_t kEnoughPeaks = 256;

/// The samples of a residual in the cells of an even grid.
struct GriddedResidual {
  VectorXd sum;                      ///< of the samples of each cell
  std::vector<std::uint16_t> count;  ///< of them
  VectorXd weight;                   ///< sum of theirs, 1 / sigma²; empty: all have 1

  [[nodiscard]] double weight_of(Index cell) const {
    return weight.size() > 0 ? weight(cell) : count[static_cast<std::size_t>(cell)];
  }
};

GriddedResidual put_on_grid(const SampleSeries& residual, double cell_s) {
  const VectorXd& t = residual.time_s;
  const auto length = static_cast<Index>(std::lround(t(t.size() - 1) / cell_s)) + 1;
  GriddedResidual out{
      VectorXd::Zero(length), std::vector<std::uint16_t>(static_cast<std::size_t>(length)), {}};
  if (residual.sigma.size() > 0) out.weight = VectorXd::Zero(length);
  for (Index i = 0; i < t.size(); ++i) {
    const auto cell = static_cast<Index>(std::lround(t(i) / cell_s));
    const double weight = residual.sigma.size() > 0 ? std::pow(residual.sigma(i), -2) : 1.0;
    out.sum(cell) += weight * residual.value(i);
    ++out.count[static_cast<std::size_t>(cell)];
    if (out.weight.size() > 0) out.weight(cell) += weight;
  }
  return out;
}

/// A residual times the beginning of an exponential window, and that window's energy.
struct WindowedResidual {
  VectorXd cells;
  double energy = 0.0;
};

/// Cells of the window.
Index window_length(const GriddedResidual& residual, double decay_per_cell) {
  return static_cast<Index>(
      std::min(kWindowEnd / decay_per_cell + 1.0, static_cast<double>(residual.sum.size())));
}

WindowedResidual apply_window(const GriddedResidual& residual, double decay_per_cell) {
  const Index end = window_length(residual, decay_per_cell);
  WindowedResidual out{VectorXd(end), 0.0};
  const double factor = std::exp(-decay_per_cell);
  double window = 1.0;
  for (Index i = 0; i < end; ++i) {
    out.cells(i) = window * residual.sum(i);
    out.energy += window * window * residual.weight_of(i);
    window *= factor;
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

/// What sinusoids of one decay explain, one a bin of a Fourier transform.
struct Gains {
  std::size_t length = 0;  ///< of the transform, in cells
  std::vector<double> gain;
};

/// @param longest_length  a power of two that has room for two of each residual
Gains gains_of(const std::vector<GriddedResidual>& residuals,
               double decay_per_cell,
               std::size_t longest_length) {
  Index longest = 0;
  for (const GriddedResidual& residual : residuals)
    longest = std::max(longest, window_length(residual, decay_per_cell));
  Gains out;
  // Few lengths: FFTW plans each one for longer than it takes to transform it.
  out.length = longest_length;
  while (out.length / kLengthFactor >= 2 * static_cast<std::size_t>(longest))
    out.length /= kLengthFactor;
  out.gain.assign(out.length / 2 + 1, 0.0);
  for (const GriddedResidual& residual : residuals) {
    WindowedResidual windowed = apply_window(residual, decay_per_cell);
    if (!(windowed.energy > 0.0)) continue;  // all of it without weight
    const auto spectrum = fourier_transform(std::move(windowed.cells), out.length);
    for (std::size_t k = 0; k < out.gain.size(); ++k) {
      out.gain[k] += std::norm(spectrum[k]) / (0.5 * windowed.energy);
    }
  }
  return out;
}

/// Largest first.
void keep_largest(std::vector<PoleCandidate>& peaks, std::size_t count) {
  const auto end = peaks.begin() + static_cast<std::ptrdiff_t>(count);
  std::partial_sort(
      peaks.begin(), end, peaks.end(), [](const PoleCandidate& a, const PoleCandidate& b) {
        return a.amplitude > b.amplitude;
      });
  peaks.erase(end, peaks.end());
}

}  // namespace

std::vector<PoleCandidate> search_residual(std::vector<SampleSeries> residuals,
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
  std::vector<GriddedResidual> gridded;
  for (const SampleSeries& residual : residuals) gridded.push_back(put_on_grid(residual, cell));
  residuals.clear();
  const std::size_t longest_length =
      std::bit_ceil(2 * (static_cast<std::size_t>(std::lround(duration / cell)) + 1));

  std::vector<PoleCandidate> peaks;
  for (double d = 0.3 / duration; d < 1.0 / (kFastestDecaySamples * step_s); d *= kDecayFactor) {
    const Gains gains = gains_of(gridded, d * cell, longest_length);
    const double bin_hz = 1.0 / (static_cast<double>(gains.length) * cell);
    const auto first = static_cast<std::size_t>(std::ceil(band_hz.low_hz / bin_hz));
    const auto last = static_cast<std::size_t>(band_hz.high_hz / bin_hz);
    const std::vector<double>& gain = gains.gain;
    for (std::size_t k = std::max<std::size_t>(first, 1); k < last && k + 1 < gain.size(); ++k) {
      if (gain[k] < gain[k - 1] || gain[k] < gain[k + 1]) continue;
      const DampedPole pole{static_cast<double>(k) * bin_hz, d};
      if (d > kTwoPi * pole.frequency_hz || is_excluded(pole, excluded, duration)) continue;
      peaks.push_back({pole, gain[k], 0.0});
      if (peaks.size() == kManyPeaks) keep_largest(peaks, kEnoughPeaks);
    }
  }
  keep_largest(peaks, peaks.size());
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
