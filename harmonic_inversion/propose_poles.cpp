// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/propose_poles.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/filter_diagonalization.hpp"
#include "harmonic_inversion/fourier.hpp"
#include "harmonic_inversion/matrix_pencil.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A spectral line stands out when it is this many times the median of the spectrum.
constexpr double kPeakStandsOut = 5.0;
/// A peak is prominent when it is this many times what parts it from a higher one.
constexpr double kProminent = 3.0;
/// Bins beside a line that belong to it.
constexpr double kBandMargin = 6.0;
/// More bins than these are not searched, only the peaks among them.
constexpr double kManyBins = 1024.0;
/// A candidate whose error exceeds this is noise that two shifts explain and a third does not.
constexpr double kMaxCandidateError = 0.5;
/// Samples a matrix pencil is given; its cost is cubic.
constexpr Index kMaxPencilSamples = 256;
/// Fewer say nothing.
constexpr Index kMinProposalSamples = 8;
/// Highest number of sinusoids a pencil is asked for.
constexpr int kMaxPencilModes = 5;
/// The pencil finds the order itself.
constexpr int kOwnOrder = 0;
/// The signal lives until this part of its energy has passed.
constexpr double kLivingEnergy = 0.998;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Magnitudes of the spectrum at the bins of a band.
struct BandSpectrum {
  double bin_hz = 0.0;
  std::size_t first = 0;  ///< bin of the first one
  std::vector<double> magnitude;

  [[nodiscard]] double frequency_hz(std::size_t k) const {
    return static_cast<double>(first + k) * bin_hz;
  }
};

BandSpectrum spectrum_in_band(VectorXd value, double step_s, const Band& band_hz) {
  const std::size_t length = std::bit_ceil(2 * static_cast<std::size_t>(value.size()));
  const auto spectrum = fourier_transform(std::move(value), length);
  BandSpectrum out;
  out.bin_hz = 1.0 / (static_cast<double>(length) * step_s);
  out.first = static_cast<std::size_t>(std::ceil(band_hz.low_hz / out.bin_hz));
  const auto last =
      std::min(spectrum.size(), static_cast<std::size_t>(band_hz.high_hz / out.bin_hz) + 1);
  for (std::size_t k = out.first; k < last; ++k) out.magnitude.push_back(std::abs(spectrum[k]));
  return out;
}

void add_band(const BandSpectrum& spectrum,
              std::size_t from,
              std::size_t to,
              const Band& limits,
              std::vector<Band>& bands) {
  const double margin = kBandMargin * spectrum.bin_hz;
  const double low = std::max(limits.low_hz, spectrum.frequency_hz(from) - margin);
  const double high = std::min(limits.high_hz, spectrum.frequency_hz(to) + margin);
  if (!bands.empty() && low <= bands.back().high_hz) {
    bands.back().high_hz = std::max(bands.back().high_hz, high);
  } else {
    bands.push_back({low, high});
  }
}

/// The least value from each bin down to the next higher one before it.
std::vector<double> lowest_before(const std::vector<double>& magnitude) {
  std::vector<double> out(magnitude.size());
  std::vector<std::size_t> higher;
  for (std::size_t k = 0; k < magnitude.size(); ++k) {
    out[k] = magnitude[k];
    while (!higher.empty() && magnitude[higher.back()] <= magnitude[k]) {
      out[k] = std::min(out[k], out[higher.back()]);
      higher.pop_back();
    }
    higher.push_back(k);
  }
  return out;
}

/// The surroundings of the peaks that rise from what parts them from higher ones. The signal is
/// tapered, lest a cut end makes peaks of its own.
std::vector<Band> prominent_bands(const EvenSeries& signal, const Band& band_hz) {
  const Index n = signal.value.size();
  VectorXd tapered(n);
  for (Index i = 0; i < n; ++i) {
    const double half = std::cos(0.5 * kPi * static_cast<double>(i) / static_cast<double>(n));
    tapered(i) = half * half * signal.value(i);
  }
  const BandSpectrum spectrum = spectrum_in_band(std::move(tapered), signal.step_s, band_hz);
  const std::vector<double>& height = spectrum.magnitude;
  const double threshold = kPeakStandsOut * median(height);
  const std::vector<double> left = lowest_before(height);
  std::vector<double> right = lowest_before({height.rbegin(), height.rend()});
  std::reverse(right.begin(), right.end());
  std::vector<Band> bands;
  for (std::size_t k = 0; k < height.size(); ++k) {
    if (height[k] < threshold || height[k] < kProminent * std::max(left[k], right[k])) continue;
    std::size_t from = k;
    std::size_t to = k;
    while (from > 0 && kProminent * height[from] > height[k]) --from;
    while (to + 1 < height.size() && kProminent * height[to] > height[k]) ++to;
    add_band(spectrum, from, to, band_hz, bands);
  }
  return bands;
}

/// Parts of the band in which the spectrum stands out of its median; where they are too wide to be
/// searched, its peaks.
std::vector<Band> interesting_bands(const EvenSeries& signal, const Band& band_hz) {
  const BandSpectrum spectrum = spectrum_in_band(signal.value, signal.step_s, band_hz);
  const std::vector<double>& magnitude = spectrum.magnitude;
  if (magnitude.size() < 8) return {band_hz};
  const double threshold = kPeakStandsOut * median(magnitude);
  std::vector<Band> bands;
  for (std::size_t k = 0; k < magnitude.size(); ++k) {
    if (magnitude[k] >= threshold) add_band(spectrum, k, k, band_hz, bands);
  }
  double bins = 0.0;
  for (const Band& band : bands) bins += (band.high_hz - band.low_hz) / spectrum.bin_hz;
  return bins > kManyBins ? prominent_bands(signal, band_hz) : bands;
}

/// Number of leading samples in which the signal still stands above the noise of its tail.
Index living_length(const VectorXd& value) {
  const Index n = value.size();
  const double noise = value.tail(std::max<Index>(n / 8, 1)).squaredNorm() /
                       static_cast<double>(std::max<Index>(n / 8, 1));
  const double total = value.squaredNorm() - noise * static_cast<double>(n);
  double sum = 0.0;
  for (Index i = 0; i < n; ++i) {
    sum += value(i) * value(i) - noise;
    if (total > 0.0 && sum >= kLivingEnergy * total) return std::min(std::max<Index>(i + 1, 16), n);
  }
  return n;
}

PoleProposal by_filter_diagonalization(const EvenSeries& signal, const Band& band_hz) {
  PoleProposal out{"filter diagonalization", {}};
  const double nyquist = 0.5 / signal.step_s;
  std::vector<Band> bands = interesting_bands(signal, band_hz);
  for (Band& band : bands) band.high_hz = std::min(band.high_hz, nyquist);
  std::erase_if(bands, [](const Band& band) { return band.low_hz >= band.high_hz; });
  for (const PoleCandidate& candidate : filter_diagonalize(signal, bands)) {
    const DampedPole& pole = candidate.pole;
    if (candidate.error > kMaxCandidateError) continue;
    if (pole.decay_per_s * signal.step_s > 1.5) continue;
    if (pole.decay_per_s > kTwoPi * pole.frequency_hz) continue;
    out.candidates.push_back(candidate);
  }
  std::sort(
      out.candidates.begin(),
      out.candidates.end(),
      [](const PoleCandidate& a, const PoleCandidate& b) { return a.amplitude > b.amplitude; });
  return out;
}

/// Means of `factor` samples each.
EvenSeries thinned(const EvenSeries& signal, Index length, Index factor) {
  EvenSeries out;
  out.step_s = signal.step_s * static_cast<double>(factor);
  out.value.resize(length / factor);
  for (Index i = 0; i < out.value.size(); ++i) {
    out.value(i) = signal.value.segment(i * factor, factor).mean();
  }
  return out;
}

void add_pencils(const EvenSeries& signal,
                 Index length,
                 const Band& band_hz,
                 const std::vector<int>& orders,
                 std::vector<PoleProposal>& out) {
  const Index factor = std::max<Index>(1, (length + kMaxPencilSamples - 1) / kMaxPencilSamples);
  const EvenSeries thin = thinned(signal, length, factor);
  for (std::vector<PoleCandidate>& found : matrix_pencil(thin, orders)) {
    std::erase_if(found, [&](const PoleCandidate& candidate) {
      const DampedPole& pole = candidate.pole;
      return pole.frequency_hz < 0.5 * band_hz.low_hz || pole.frequency_hz > band_hz.high_hz ||
             pole.decay_per_s * signal.step_s > 1.5;
    });
    if (!found.empty()) out.push_back({"matrix pencil", std::move(found)});
  }
}

}  // namespace

std::optional<EvenSeries> on_even_grid(const SampleSeries& series, double step_s) {
  const Index n = series.time_s.size();
  if (n < 2) return std::nullopt;
  // From sample to sample, so that stamps that swing about an even grid, as a rolling shutter's do,
  // find their places whatever the first one's is.
  std::vector<Index> places(static_cast<std::size_t>(n), 0);
  double origin = 0.0;
  for (Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (i > 0) {
      places[k] =
          places[k - 1] +
          static_cast<Index>(std::lround((series.time_s(i) - series.time_s(i - 1)) / step_s));
      if (places[k] == places[k - 1]) return std::nullopt;
    }
    origin += (series.time_s(i) - static_cast<double>(places[k]) * step_s) / static_cast<double>(n);
  }
  const Index length = places.back() + 1;
  if (static_cast<double>(length) * 0.6 > static_cast<double>(n)) return std::nullopt;
  EvenSeries out{step_s, VectorXd::Zero(length)};
  Index previous = 0;
  for (Index i = 0; i < n; ++i) {
    const Index index = places[static_cast<std::size_t>(i)];
    const double place = (series.time_s(i) - origin) / step_s;
    if (std::abs(place - static_cast<double>(index)) > 1.0 / 3.0) return std::nullopt;
    out.value(index) = series.value(i);
    for (Index j = previous + 1; j < index; ++j) {
      const double part = static_cast<double>(j - previous) / static_cast<double>(index - previous);
      out.value(j) = (1.0 - part) * out.value(previous) + part * series.value(i);
    }
    previous = index;
  }
  return out;
}

std::vector<PoleProposal> propose_by_filter_diagonalization(const SampleSeries& series,
                                                            double step_s,
                                                            const Band& band_hz) {
  std::vector<PoleProposal> out;
  const std::optional<EvenSeries> even = on_even_grid(series, step_s);
  if (!even || even->value.size() < kMinProposalSamples) return out;
  out.push_back(by_filter_diagonalization(*even, band_hz));
  const Index living = living_length(even->value);
  if (5 * living < 3 * even->value.size()) {
    out.push_back(by_filter_diagonalization({step_s, even->value.head(living)}, band_hz));
  }
  std::erase_if(out, [](const PoleProposal& proposal) { return proposal.candidates.empty(); });
  return out;
}

std::vector<PoleProposal> propose_by_matrix_pencil(const SampleSeries& series,
                                                   double step_s,
                                                   const Band& band_hz) {
  std::vector<PoleProposal> out;
  const std::optional<EvenSeries> even = on_even_grid(series, step_s);
  if (!even || even->value.size() < kMinProposalSamples) return out;
  std::vector<int> orders = {kOwnOrder};
  for (int modes = 1; modes <= kMaxPencilModes; ++modes) {
    orders.push_back(2 * modes);
    orders.push_back(2 * modes + 1);  // room for what the baseline left
  }
  const Index all = even->value.size();
  const Index living = living_length(even->value);
  add_pencils(*even, living, band_hz, orders, out);
  if (living > kMaxPencilSamples) add_pencils(*even, kMaxPencilSamples, band_hz, orders, out);
  // Many modes need every sample.
  if (living < all && all <= kMaxPencilSamples) add_pencils(*even, all, band_hz, {kOwnOrder}, out);
  return out;
}

}  // namespace twang
