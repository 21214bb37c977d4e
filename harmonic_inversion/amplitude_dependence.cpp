// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/amplitude_dependence.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/evaluate_modes.hpp"
#include "harmonic_inversion/mode_window.hpp"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kSinksTo = 3.0;  // of the residual, the amplitude at the end of the last window
constexpr double kTenth = 0.1;    // of a period, in which its end is looked for
constexpr double kLeastPeriods = 2.0;
constexpr double kLeastFall = 0.4;            // of ln A, in a window: a fifth of a decade
constexpr double kMostWindows = 8.0;          // of one recording
constexpr double kLeastSurplus = 2.0;         // samples of a window over its unknowns
constexpr double kFrequencyRoundOff = 1e-12;  // of f
constexpr double kCounts = 3.0;               // sigmas from which a trend counts
constexpr double kNegligible = 1e-4;  // of f, and a hundred times that of d: no trend to speak of

/// The strongest mode of an inversion with what overlaps it, which may be no more than its change
/// with amplitude; all else is taken away from the samples.
class ModeAlone {
 public:
  ModeAlone(const std::vector<SampleSeries>& series, const InversionResult& whole)
      : m_series(series), m_whole(whole), m_others(whole) {
    const DampedSinusoid& strongest = whole.modes.front();
    m_others.modes.clear();
    for (const DampedSinusoid& mode : whole.modes) {
      const double width = (strongest.decay_per_s + mode.decay_per_s) / kTwoPi;
      const bool belongs =
          &mode == &strongest || std::abs(mode.frequency_hz - strongest.frequency_hz) < width;
      (belongs ? m_parts : m_others.modes).push_back(mode);
    }
  }

  /// Whether more than one sinusoid makes up the mode.
  [[nodiscard]] bool overlaps() const { return m_parts.size() > 1; }

  /// Its amplitude, root sum of squares over some channels, after so long a time.
  [[nodiscard]] double amplitude_at(double time_s,
                                    std::size_t first_series,
                                    std::size_t num_channels) const {
    double squares = 0.0;
    for (std::size_t c = first_series; c < first_series + num_channels; ++c) {
      std::complex<double> sum = 0.0;
      for (const DampedSinusoid& part : m_parts) {
        const double turned = kTwoPi * (part.frequency_hz - m_parts.front().frequency_hz) * time_s;
        sum += std::polar(part.channels[c].amplitude * std::exp(-part.decay_per_s * time_s),
                          part.channels[c].phase_rad + turned);
      }
      squares += std::norm(sum);
    }
    return std::sqrt(squares);
  }

  [[nodiscard]] WindowSamples cut(std::size_t first_series,
                                  std::size_t num_channels,
                                  double from_s,
                                  double to_s) const {
    WindowSamples out;
    const double middle = 0.5 * (from_s + to_s);
    out.recording = first_series / num_channels;
    const double origin = m_whole.origin_s(first_series);
    out.start_s = origin + to_s;
    out.end_s = origin + from_s;
    for (std::size_t c = first_series; c < first_series + num_channels; ++c) {
      const SampleSeries& s = m_series[c];
      const auto begin = std::lower_bound(s.time_s.begin(), s.time_s.end(), from_s);
      const auto end = std::lower_bound(begin, s.time_s.end(), to_s);
      const Index first = begin - s.time_s.begin();
      const Index count = end - begin;
      const VectorXd time_s = s.time_s.segment(first, count);
      if (count > 0) {
        out.start_s = std::min(out.start_s, origin + time_s(0));
        out.end_s = std::max(out.end_s, origin + time_s(count - 1));
      }
      out.time_s.emplace_back(time_s.array() - middle);
      out.value.emplace_back(s.value.segment(first, count) - evaluate_modes(m_others, c, time_s));
    }
    return out;
  }

  /// Residual of the whole model in some series, root sum of mean squares.
  [[nodiscard]] double residual(std::size_t first_series, std::size_t num_channels) const {
    double sum = 0.0;
    for (std::size_t c = first_series; c < first_series + num_channels; ++c) {
      const SampleSeries& s = m_series[c];
      const double squares = (s.value - evaluate_modes(m_whole, c, s.time_s)).squaredNorm();
      sum += squares / static_cast<double>(s.value.size());
    }
    return std::sqrt(sum);
  }

  /// Bounds of the windows of some series, one recording's, from its origin [s].
  [[nodiscard]] std::vector<double> window_bounds(std::size_t first_series,
                                                  std::size_t num_channels) const {
    const auto amplitude = [&](double t) { return amplitude_at(t, first_series, num_channels); };
    const Eigen::VectorXd& time_s = m_series[first_series].time_s;
    const double period_s = 1.0 / m_parts.front().frequency_hz;
    const double least = kSinksTo * residual(first_series, num_channels);
    const double last_s = time_s(time_s.size() - 1) + 1e-9 * period_s;
    double end_s = 0.0;
    while (end_s < last_s && amplitude(end_s) > least) end_s += kTenth * period_s;
    end_s = std::min(end_s, last_s);
    const auto samples =
        static_cast<double>(std::lower_bound(time_s.begin(), time_s.end(), end_s) - time_s.begin());
    const auto channels = static_cast<double>(num_channels);
    const double unknowns = 2.0 + 2.0 * channels + kLeastSurplus * channels;
    const double most = std::min({end_s / (kLeastPeriods * period_s),
                                  std::log(amplitude(0.0) / amplitude(end_s)) / kLeastFall,
                                  samples * channels / unknowns,
                                  kMostWindows});
    const auto count = static_cast<int>(std::floor(most));
    std::vector<double> bounds;
    if (count < 2) return bounds;
    for (int i = 0; i <= count; ++i) bounds.push_back(end_s * i / count);
    return bounds;
  }

 private:
  const std::vector<SampleSeries>& m_series;
  const InversionResult& m_whole;
  InversionResult m_others;
  std::vector<DampedSinusoid> m_parts;
};

/// The slope of a straight line through points with sigmas.
struct Trend {
  double slope = 0.0;
  double slope_sigma = 0.0;
};

Trend fit_trend(const VectorXd& x, const VectorXd& y, const VectorXd& sigma) {
  const VectorXd weight = sigma.array().square().inverse();
  const VectorXd centred = x.array() - weight.dot(x) / weight.sum();
  const double spread = weight.dot(centred.cwiseProduct(centred));
  Trend trend;
  trend.slope = weight.dot(centred.cwiseProduct(y)) / spread;
  const VectorXd rest = y.array() - weight.dot(y) / weight.sum() - trend.slope * centred.array();
  // Scatter about the line beyond the sigmas, from release to release say, widens them.
  const double freedom = static_cast<double>(x.size()) - 2.0;
  const double excess =
      freedom > 0.0 ? std::max(1.0, weight.dot(rest.cwiseProduct(rest)) / freedom) : 1.0;
  trend.slope_sigma = std::sqrt(excess / spread);
  return trend;
}

/// Of the third of the windows with the largest and of that with the smallest amplitudes.
struct Ends {
  double at_large = 0.0;
  double at_small = 0.0;
};

Ends ends_of(const std::vector<Index>& ascending, const VectorXd& y, const VectorXd& sigma) {
  const std::size_t third = (ascending.size() + 2) / 3;
  const auto mean = [&](auto first) {
    double sum = 0.0;
    double weights = 0.0;
    for (auto i = first; i < first + static_cast<std::ptrdiff_t>(third); ++i) {
      const double weight = 1.0 / (sigma(*i) * sigma(*i));
      sum += weight * y(*i);
      weights += weight;
    }
    return sum / weights;
  };
  return {mean(ascending.end() - static_cast<std::ptrdiff_t>(third)), mean(ascending.begin())};
}

/// f and d of the windows, and their trends over ln A.
struct Trends {
  VectorXd log_amplitude;
  Eigen::MatrixX2d value;
  Eigen::MatrixX2d sigma;
  [[nodiscard]] Trend of(Index column) const {
    return fit_trend(log_amplitude, value.col(column), sigma.col(column));
  }
  [[nodiscard]] Ends ends(Index column) const {
    std::vector<Index> ascending(static_cast<std::size_t>(log_amplitude.size()));
    std::iota(ascending.begin(), ascending.end(), 0);
    std::sort(ascending.begin(), ascending.end(), [&](Index a, Index b) {
      return log_amplitude(a) < log_amplitude(b);
    });
    return ends_of(ascending, value.col(column), sigma.col(column));
  }
};

std::string describe(const Trends& trends, bool frequency_counts, bool decay_counts) {
  std::vector<std::string> parts;
  if (frequency_counts) {
    const Ends f = trends.ends(0);
    parts.push_back(
        fmt::format("the frequency goes from {:.5g} to {:.5g} Hz (it {} with amplitude)",
                    f.at_large,
                    f.at_small,
                    f.at_large < f.at_small ? "softens" : "stiffens"));
  }
  if (decay_counts) {
    const Ends d = trends.ends(1);
    parts.push_back(fmt::format("the decay goes from {:.3g} to {:.3g} 1/s ({})",
                                d.at_large,
                                d.at_small,
                                d.at_large < d.at_small
                                    ? "more at small amplitude, as with dry friction"
                                    : "more at large amplitude, as with drag or strain"));
  }
  return fmt::format(
      "no pure exponential: between amplitudes of {:.3g} and {:.3g} {}; frequency and decay hold "
      "near the amplitudes used.",
      std::exp(trends.log_amplitude.maxCoeff()),
      std::exp(trends.log_amplitude.minCoeff()),
      fmt::join(parts, " and "));
}

}  // namespace

AmplitudeDependence amplitude_dependence(const std::vector<SampleSeries>& series,
                                         std::size_t num_traces,
                                         const InversionResult& whole) {
  AmplitudeDependence out;
  if (whole.modes.empty() || num_traces == 0) return out;
  const DampedSinusoid& mode = whole.modes.front();
  const std::size_t num_channels = series.size() / num_traces;
  const ModeAlone alone(series, whole);
  std::vector<WindowFit> fits;
  double squares = 0.0;
  Index freedom = 0;
  for (std::size_t first = 0; first < series.size(); first += num_channels) {
    const std::vector<double> bounds = alone.window_bounds(first, num_channels);
    for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
      const WindowSamples samples = alone.cut(first, num_channels, bounds[i], bounds[i + 1]);
      if (samples.size() <= samples.num_unknowns()) continue;
      const double fall = std::log(alone.amplitude_at(bounds[i], first, num_channels) /
                                   alone.amplitude_at(bounds[i + 1], first, num_channels));
      const auto fit = fit_window(samples, mode.frequency_hz, fall / (bounds[i + 1] - bounds[i]));
      if (!fit) continue;
      fits.push_back(*fit);
      squares += fit->sum_of_squares;
      freedom += fit->freedom;
      AmplitudeWindow window;
      window.recording = samples.recording;
      window.start_s = samples.start_s;
      window.end_s = samples.end_s;
      window.amplitude = fit->amplitude;
      window.frequency_hz = fit->frequency_hz;
      window.decay_per_s = fit->decay_per_s;
      out.windows.push_back(window);
    }
  }
  const auto count = static_cast<Index>(fits.size());
  if (count < 2) return {};
  const double variance = squares / static_cast<double>(freedom);
  Trends trends;
  trends.log_amplitude.resize(count);
  trends.value.resize(count, 2);
  trends.sigma.resize(count, 2);
  for (Index i = 0; i < count; ++i) {
    AmplitudeWindow& window = out.windows[static_cast<std::size_t>(i)];
    const WindowFit& fit = fits[static_cast<std::size_t>(i)];
    window.frequency_sigma_hz = std::sqrt(variance * fit.covariance(0, 0));
    window.decay_sigma_per_s = std::sqrt(variance * fit.covariance(1, 1));
    const double round_off = kFrequencyRoundOff * mode.frequency_hz;
    trends.log_amplitude(i) = std::log(window.amplitude);
    trends.value.row(i) << window.frequency_hz, window.decay_per_s;
    trends.sigma.row(i) << std::max(window.frequency_sigma_hz, round_off),
        std::max(window.decay_sigma_per_s, round_off);
  }
  const Trend frequency = trends.of(0);
  const Trend decay = trends.of(1);
  out.frequency_trend = frequency.slope / frequency.slope_sigma;
  out.decay_trend = decay.slope / decay.slope_sigma;
  const bool frequency_counts = std::abs(out.frequency_trend) > kCounts &&
                                std::abs(frequency.slope) > kNegligible * mode.frequency_hz;
  const bool decay_counts = std::abs(out.decay_trend) > kCounts &&
                            std::abs(decay.slope) > 100.0 * kNegligible * mode.decay_per_s;
  if (frequency_counts || decay_counts) {
    out.sentence = alone.overlaps() ? "If the modes that overlap are one, it is " : "It is ";
    out.sentence += describe(trends, frequency_counts, decay_counts);
  }
  return out;
}

}  // namespace twang
