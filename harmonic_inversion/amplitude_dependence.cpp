// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/amplitude_dependence.hpp"

#include "core/constants.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSinksTo = 3.0;  // of the residual, the amplitude at the end of the last window
constexpr double kLeastPeriods = 2.0;
constexpr double kLeastFall = 0.4;     // of ln A, in a window: a fifth of a decade
constexpr double kMostWindows = 8.0;   // of one recording
constexpr double kLeastSurplus = 2.0;  // samples of a window over its unknowns
constexpr int kIterations = 30;
constexpr double kStep = 1e-10;       // of f, at which the iteration stops
constexpr double kCounts = 3.0;       // sigmas from which a trend counts
constexpr double kNegligible = 1e-4;  // of f, and a hundred times that of d: no trend to speak of

/// The samples of one window, without what is not the mode; time from its middle.
struct WindowSamples {
  std::vector<VectorXd> time_s;  // one a channel
  std::vector<VectorXd> value;
  double start_s = 0.0;  // in the recording's time
  double end_s = 0.0;
  std::size_t recording = 0;
  [[nodiscard]] Index size() const {
    Index sum = 0;
    for (const VectorXd& channel : value) sum += channel.size();
    return sum;
  }
  [[nodiscard]] Index num_unknowns() const { return 2 + 2 * static_cast<Index>(value.size()); }
};

/// The mode in one window: f, d and their covariance for unit variance of the residual.
struct WindowFit {
  double frequency_hz = 0.0;
  double decay_per_s = 0.0;
  double amplitude = 0.0;  // in the middle
  Eigen::Matrix2d covariance;
  double sum_of_squares = 0.0;
  Index freedom = 0;
};

/// Gauss-Newton for f and d of one damped sinusoid, its amplitudes solved for with them.
std::optional<WindowFit> fit_window(const WindowSamples& samples, double f, double d) {
  const Index columns = samples.num_unknowns();
  const auto num_channels = static_cast<Index>(samples.value.size());
  VectorXd x = VectorXd::Zero(2 * num_channels);  // cosine and sine of each channel
  WindowFit fit;
  double step = 0.0;
  for (int iteration = 0; iteration <= kIterations; ++iteration) {
    MatrixXd normal = MatrixXd::Zero(columns, columns);
    VectorXd right = VectorXd::Zero(columns);
    fit.sum_of_squares = 0.0;
    for (Index c = 0; c < num_channels; ++c) {
      const VectorXd& t = samples.time_s[static_cast<std::size_t>(c)];
      const VectorXd& y = samples.value[static_cast<std::size_t>(c)];
      for (Index i = 0; i < t.size(); ++i) {
        const double size = std::exp(-d * t(i));
        const double cosine = size * std::cos(kTwoPi * f * t(i));
        const double sine = size * std::sin(kTwoPi * f * t(i));
        const double a = x(2 * c);
        const double b = x(2 * c + 1);
        const double model = a * cosine + b * sine;
        VectorXd row = VectorXd::Zero(columns);
        row(0) = kTwoPi * t(i) * (b * cosine - a * sine);
        row(1) = -t(i) * model;
        row(2 + 2 * c) = cosine;
        row(3 + 2 * c) = sine;
        const double r = y(i) - model;
        fit.sum_of_squares += r * r;
        normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
        right += r * row;
      }
    }
    normal = normal.selfadjointView<Eigen::Lower>();
    const bool only_amplitudes = iteration == 0;  // f and d have no effect before there are some
    if (only_amplitudes) {
      x = normal.bottomRightCorner(columns - 2, columns - 2).ldlt().solve(right.tail(columns - 2));
      continue;
    }
    const Eigen::LDLT<MatrixXd> ldlt(normal);
    if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0.0)) return std::nullopt;
    if (iteration > 1 && step <= kStep * f) {
      fit.frequency_hz = f;
      fit.decay_per_s = d;
      fit.amplitude = x.norm();
      fit.freedom = samples.size() - columns;
      fit.covariance = ldlt.solve(MatrixXd::Identity(columns, columns)).topLeftCorner<2, 2>();
      return fit;
    }
    const VectorXd change = ldlt.solve(right);
    if (!change.allFinite()) return std::nullopt;
    f += change(0);
    d += change(1);
    x += change.tail(columns - 2);
    step = std::abs(change(0)) + std::abs(change(1)) / kTwoPi;
    if (!(f > 0.0)) return std::nullopt;
  }
  return std::nullopt;
}

/// What is left of a series in a window [from, to) once all but the strongest mode is taken away.
class ModeAlone {
 public:
  ModeAlone(const std::vector<SampleSeries>& series, const InversionResult& whole)
      : m_series(series), m_whole(whole), m_others(whole) {
    m_others.modes.erase(m_others.modes.begin());
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
      VectorXd value = s.value.segment(first, count);
      for (Index i = 0; i < count; ++i) {
        value(i) -= m_others.evaluate(c, s.time_s(first + i) + m_whole.origin_s(c));
      }
      if (count > 0) {
        out.start_s = std::min(out.start_s, origin + s.time_s(first));
        out.end_s = std::max(out.end_s, origin + s.time_s(first + count - 1));
      }
      out.time_s.emplace_back(s.time_s.segment(first, count).array() - middle);
      out.value.push_back(std::move(value));
    }
    return out;
  }

  /// The mode's amplitude at the origin and the residual of some series, root sums of squares.
  [[nodiscard]] std::pair<double, double> amplitude_and_residual(std::size_t first_series,
                                                                 std::size_t num_channels) const {
    double amplitude = 0.0;
    double residual = 0.0;
    for (std::size_t c = first_series; c < first_series + num_channels; ++c) {
      const SampleSeries& s = m_series[c];
      amplitude += std::pow(m_whole.modes.front().channels[c].amplitude, 2);
      double squares = 0.0;
      for (Index i = 0; i < s.value.size(); ++i) {
        squares += std::pow(s.value(i) - m_whole.evaluate(c, s.time_s(i) + m_whole.origin_s(c)), 2);
      }
      residual += squares / static_cast<double>(s.value.size());
    }
    return {std::sqrt(amplitude), std::sqrt(residual)};
  }

 private:
  const std::vector<SampleSeries>& m_series;
  const InversionResult& m_whole;
  InversionResult m_others;
};

/// Boundaries of the windows of one recording, from its origin [s].
std::vector<double> window_bounds(const SampleSeries& series,
                                  const DampedSinusoid& mode,
                                  double amplitude,
                                  double residual,
                                  std::size_t num_channels) {
  const double period_s = 1.0 / mode.frequency_hz;
  double end_s = series.time_s(series.time_s.size() - 1) + 1e-9 * period_s;
  if (mode.decay_per_s > 0.0 && residual > 0.0) {
    end_s = std::min(end_s, std::log(amplitude / (kSinksTo * residual)) / mode.decay_per_s);
  }
  if (!(end_s > 0.0)) return {};
  const auto samples = static_cast<double>(
      std::lower_bound(series.time_s.begin(), series.time_s.end(), end_s) - series.time_s.begin());
  const auto channels = static_cast<double>(num_channels);
  const double unknowns = 2.0 + 2.0 * channels + kLeastSurplus * channels;
  const double most = std::min({end_s / (kLeastPeriods * period_s),
                                end_s * mode.decay_per_s / kLeastFall,
                                samples * channels / unknowns,
                                kMostWindows});
  const auto count = static_cast<int>(std::floor(most));
  std::vector<double> bounds;
  if (count < 2) return bounds;
  for (int i = 0; i <= count; ++i) bounds.push_back(end_s * i / count);
  return bounds;
}

/// A straight line y = y0 + slope (x - mean x) through points with sigmas.
struct Trend {
  double mean = 0.0;
  double slope = 0.0;
  double slope_sigma = 0.0;
  double mean_x = 0.0;
};

Trend fit_trend(const VectorXd& x, const VectorXd& y, const VectorXd& sigma) {
  const VectorXd weight = sigma.array().square().inverse();
  Trend trend;
  trend.mean_x = weight.dot(x) / weight.sum();
  trend.mean = weight.dot(y) / weight.sum();
  const VectorXd centred = x.array() - trend.mean_x;
  const double spread = weight.dot(centred.cwiseProduct(centred));
  trend.slope = weight.dot(centred.cwiseProduct(y)) / spread;
  const VectorXd rest = y.array() - trend.mean - trend.slope * centred.array();
  // Scatter about the line beyond the sigmas, from release to release say, widens them.
  const double freedom = static_cast<double>(x.size()) - 2.0;
  const double excess =
      freedom > 0.0 ? std::max(1.0, weight.dot(rest.cwiseProduct(rest)) / freedom) : 1.0;
  trend.slope_sigma = std::sqrt(excess / spread);
  return trend;
}

/// What a trend says, if it says anything: its value at the largest and the smallest amplitude.
struct Ends {
  double at_large = 0.0;
  double at_small = 0.0;
};

Ends ends_of(const Trend& trend, const VectorXd& log_amplitude) {
  return {trend.mean + trend.slope * (log_amplitude.maxCoeff() - trend.mean_x),
          trend.mean + trend.slope * (log_amplitude.minCoeff() - trend.mean_x)};
}

std::string describe(const Trend& frequency,
                     const Trend& decay,
                     bool frequency_counts,
                     bool decay_counts,
                     const VectorXd& log_amplitude) {
  std::string text = fmt::format("Not a pure exponential: between amplitudes of {:.3g} and {:.3g} ",
                                 std::exp(log_amplitude.maxCoeff()),
                                 std::exp(log_amplitude.minCoeff()));
  if (frequency_counts) {
    const Ends f = ends_of(frequency, log_amplitude);
    text += fmt::format(
        "the frequency goes from {:.5g} to {:.5g} Hz ({})",
        f.at_large,
        f.at_small,
        f.at_large < f.at_small ? "it softens with amplitude" : "it stiffens with amplitude");
  }
  if (frequency_counts && decay_counts) text += " and ";
  if (decay_counts) {
    const Ends d = ends_of(decay, log_amplitude);
    text +=
        fmt::format("the decay from {:.3g} to {:.3g} 1/s ({})",
                    d.at_large,
                    d.at_small,
                    d.at_large < d.at_small ? "more at small amplitude, as with dry friction"
                                            : "more at large amplitude, as with drag or strain");
  }
  return text + "; frequency and decay hold near the amplitudes used.";
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
    const auto [amplitude, residual] = alone.amplitude_and_residual(first, num_channels);
    const std::vector<double> bounds =
        window_bounds(series[first], mode, amplitude, residual, num_channels);
    for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
      const WindowSamples samples = alone.cut(first, num_channels, bounds[i], bounds[i + 1]);
      if (samples.size() <= samples.num_unknowns()) continue;
      const auto fit = fit_window(samples, mode.frequency_hz, mode.decay_per_s);
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
  VectorXd log_amplitude(count);
  Eigen::MatrixX2d values(count, 2);
  Eigen::MatrixX2d sigmas(count, 2);
  for (Index i = 0; i < count; ++i) {
    AmplitudeWindow& window = out.windows[static_cast<std::size_t>(i)];
    const WindowFit& fit = fits[static_cast<std::size_t>(i)];
    window.frequency_sigma_hz = std::sqrt(variance * fit.covariance(0, 0));
    window.decay_sigma_per_s = std::sqrt(variance * fit.covariance(1, 1));
    log_amplitude(i) = std::log(window.amplitude);
    values.row(i) << window.frequency_hz, window.decay_per_s;
    sigmas.row(i) << std::max(window.frequency_sigma_hz, 1e-12 * mode.frequency_hz),
        std::max(window.decay_sigma_per_s, 1e-12 * mode.frequency_hz);
  }
  const Trend frequency = fit_trend(log_amplitude, values.col(0), sigmas.col(0));
  const Trend decay = fit_trend(log_amplitude, values.col(1), sigmas.col(1));
  out.frequency_trend = frequency.slope / frequency.slope_sigma;
  out.decay_trend = decay.slope / decay.slope_sigma;
  const bool frequency_counts = std::abs(out.frequency_trend) > kCounts &&
                                std::abs(frequency.slope) > kNegligible * mode.frequency_hz;
  const bool decay_counts = std::abs(out.decay_trend) > kCounts &&
                            std::abs(decay.slope) > 100.0 * kNegligible * mode.decay_per_s;
  if (frequency_counts || decay_counts) {
    out.sentence = describe(frequency, decay, frequency_counts, decay_counts, log_amplitude);
  }
  return out;
}

}  // namespace twang
