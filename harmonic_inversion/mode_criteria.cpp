// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/mode_criteria.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/select_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Independent places (f, d) in the search, per sample: found on white noise, see the tests.
constexpr double kCellsPerSample = 4.0;
/// A decay is called negative beyond this many sigma.
constexpr double kGrowthSigmas = 3.0;
/// The damping ratio of a lone mode is called too high beyond this many sigma.
constexpr double kDampingSigmas = 3.0;
/// A heavily damped mode must have this part of the strongest mode's energy to be one.
constexpr double kTransientEnergyPart = 0.05;
constexpr double kTransientDampingRatio = 0.35;
/// So must one that is gone within a few samples: it may be no more than a bad first sample.
constexpr double kTransientDecayPerSample = 0.25;
constexpr double kBriefEnergyPart = 0.01;
/// An overlapping mode must lower the residual by this factor, or explain this part (rms) of the
/// mode it overlaps: real material changes frequency and damping with amplitude by a few percent.
constexpr double kOverlapResidualFactor = 3.0;
constexpr double kOverlapExplainedPart = 0.25;
/// An amplitude below this many sigma says that the fit cannot tell the mode from others.
constexpr double kMinAmplitudeSigmas = 3.0;
/// Unless it is the only one, and this many sigma large were its pole known: twice what noise
/// makes.
constexpr double kSureAmplitudeSigmas = 10.0;
/// Outliers: this many robust sigma, with neighbours below the second number or this part of them.
constexpr double kOutlierSigmas = 7.0;
constexpr double kOutlierNeighbourSigmas = 4.0;
constexpr double kOutlierNeighbourPart = 0.25;
/// Above this part of the samples it is not outliers but the model that is wrong.
constexpr double kMaxOutlierPart = 0.02;

double damping_ratio(const DampedPole& pole) {
  return pole.decay_per_s / std::hypot(kTwoPi * pole.frequency_hz, pole.decay_per_s);
}

/// Of the damping ratio of pole `k`.
double damping_ratio_sigma(const SinusoidFit& fit, std::size_t k) {
  const double omega = kTwoPi * fit.poles[k].frequency_hz;
  const double decay = fit.poles[k].decay_per_s;
  const auto i = 2 * static_cast<Index>(k);
  const Eigen::Vector2d gradient =
      omega / std::pow(std::hypot(omega, decay), 3) * Eigen::Vector2d(-kTwoPi * decay, omega);
  const double variance = gradient.dot(fit.pole_covariance.block<2, 2>(i, i) * gradient);
  return std::sqrt(std::max(variance, 0.0) * fit.variance());
}

}  // namespace

double bayes_criterion(const SinusoidFit& fit) {
  const double n = fit.num_samples;
  return n * std::log(std::max(fit.sum_of_squares / n, 1e-300)) + fit.num_parameters * std::log(n);
}

double log_chance_of_gain(double before, double after, int num_free, int num_linear) {
  if (!(after < before)) return 0.0;
  if (num_free < 1) return 0.0;
  const double a = 0.5 * num_free;
  const double r = after / before;
  // I_r(a, m) = r^a sum_{j < m} (a)_j / j! (1 - r)^j for whole m.
  double sum = 0.0;
  double term = 1.0;
  for (int j = 0; j < num_linear / 2; ++j) {
    sum += term;
    term *= (a + j) / (j + 1.0) * (1.0 - r);
  }
  return std::min(0.0, a * std::log(std::max(r, 1e-300)) + std::log(sum));
}

std::vector<bool> find_isolated_outliers(const VectorXd& residual) {
  const auto n = static_cast<std::size_t>(residual.size());
  std::vector<bool> out(n, false);
  std::vector<double> magnitude(n);
  for (std::size_t i = 0; i < n; ++i) magnitude[i] = std::abs(residual(static_cast<Index>(i)));
  std::vector<double> sorted = magnitude;
  std::nth_element(
      sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n / 2), sorted.end());
  const double sigma = 1.4826 * sorted[n / 2];
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (magnitude[i] <= kOutlierSigmas * sigma) continue;
    const double left = i > 0 ? magnitude[i - 1] : 0.0;
    const double right = i + 1 < n ? magnitude[i + 1] : 0.0;
    out[i] = std::max(left, right) <
             std::max(kOutlierNeighbourSigmas * sigma, kOutlierNeighbourPart * magnitude[i]);
    count += out[i] ? 1 : 0;
  }
  if (static_cast<double>(count) > kMaxOutlierPart * static_cast<double>(n)) out.assign(n, false);
  return out;
}

ModeCriteria::ModeCriteria(const std::vector<SampleSeries>& series, const SelectionOptions& options)
    : m_series(series), m_options(options) {
  for (const SampleSeries& s : series) {
    const double spread = std::sqrt((s.value.array() - s.value.mean()).square().mean());
    m_scale.push_back(spread > 0.0 ? 1.0 / spread : 0.0);
  }
}

bool ModeCriteria::is_supported(const SinusoidFit& smaller, const SinusoidFit& larger) const {
  if (!(bayes_criterion(larger) < bayes_criterion(smaller))) return false;
  const int num_free = larger.num_samples - larger.num_parameters;
  const int num_linear = 2 * static_cast<int>(m_series.size());
  const double log_chance =
      log_chance_of_gain(smaller.sum_of_squares, larger.sum_of_squares, num_free, num_linear);
  return log_chance + std::log(kCellsPerSample * larger.num_samples) <
         std::log(m_options.false_alarm_rate);
}

double ModeCriteria::least_gain(int num_samples) const {
  // n ln(1 + gain / n) falls short of gain by little where it matters; a lower bound is wanted.
  const double n = num_samples;
  return (2.0 + 2.0 * static_cast<double>(m_series.size())) * std::log(n) *
         std::min(1.0, 0.5 + n / 200.0);
}

std::optional<std::string> ModeCriteria::objection(const SinusoidFit& fit, std::size_t k) const {
  const DampedPole& pole = fit.poles[k];
  const Band& band = m_options.band_hz;
  if (pole.frequency_hz < band.low_hz || pole.frequency_hz > band.high_hz) {
    return fmt::format("outside the band {:.4g} to {:.4g} Hz", band.low_hz, band.high_hz);
  }
  if (pole.decay_per_s * m_options.step_s > m_options.max_decay_per_sample) {
    return "decays within a sample";
  }
  const double ratio = damping_ratio(pole);
  const double chance =
      is_lone_and_sure(fit, k) ? kDampingSigmas * damping_ratio_sigma(fit, k) : 0.0;
  if (std::abs(ratio) > m_options.max_damping_ratio + chance) {
    return fmt::format("damping ratio {:.2f}: a moving baseline, not a vibration", ratio);
  }
  if (!(amplitude_over_sigma(fit, k) > kMinAmplitudeSigmas) && !is_lone_and_sure(fit, k)) {
    return "amplitude not determined by the data";
  }
  const bool heavy = std::abs(ratio) > kTransientDampingRatio;
  const bool brief = std::abs(pole.decay_per_s) * m_options.step_s > kTransientDecayPerSample;
  if (heavy || brief) {
    double strongest = 0.0;
    for (std::size_t j = 0; j < fit.poles.size(); ++j) {
      strongest = std::max(strongest, energy(fit, j));
    }
    if (energy(fit, k) < (heavy ? kTransientEnergyPart : kBriefEnergyPart) * strongest) {
      return fmt::format(
          "damping ratio {:.2f}, brief and weak: a transient beside the strongest mode", ratio);
    }
  }
  return std::nullopt;
}

std::optional<std::size_t> ModeCriteria::overlapped_by(const SinusoidFit& fit,
                                                       std::size_t k) const {
  const DampedPole& pole = fit.poles[k];
  const double own_energy = energy(fit, k);
  std::optional<std::size_t> out;
  for (std::size_t j = 0; j < fit.poles.size(); ++j) {
    if (j == k || energy(fit, j) < own_energy) continue;
    const DampedPole& other = fit.poles[j];
    const double width = (std::abs(pole.decay_per_s) + std::abs(other.decay_per_s)) / kTwoPi;
    if (std::abs(pole.frequency_hz - other.frequency_hz) < width) out = j;
  }
  return out;
}

std::optional<std::string> ModeCriteria::overlap_objection(const SinusoidFit& fit,
                                                           std::size_t k,
                                                           const SinusoidFit& without) const {
  const std::optional<std::size_t> other = overlapped_by(fit, k);
  if (!other) return std::nullopt;
  const double before = without.sum_of_squares;
  const double after = fit.sum_of_squares;
  if (before > kOverlapResidualFactor * kOverlapResidualFactor * after) return std::nullopt;
  double explained = 0.0;
  double signal = 0.0;
  for (std::size_t c = 0; c < m_series.size(); ++c) {
    const double scale = m_scale[c] * m_scale[c];
    explained += scale * (without.channels[c].sum_of_squares - fit.channels[c].sum_of_squares);
    signal += scale * (m_series[c].value.array() - without.channels[c].offset).square().sum();
  }
  if (explained > kOverlapExplainedPart * kOverlapExplainedPart * signal) return std::nullopt;
  return fmt::format("cannot be told from a slight change of the {:.4g} Hz mode with amplitude",
                     fit.poles[*other].frequency_hz);
}

bool ModeCriteria::needs_refit_to_judge(const SinusoidFit& fit, std::size_t k) const {
  return overlapped_by(fit, k).has_value() || amplitude_over_sigma(fit, k) < 12.0;
}

bool ModeCriteria::is_growing(const SinusoidFit& fit, std::size_t k) const {
  const auto i = 2 * static_cast<Index>(k) + 1;
  const double sigma = std::sqrt(fit.pole_covariance(i, i) * fit.variance());
  return fit.poles[k].decay_per_s < -kGrowthSigmas * sigma;
}

double ModeCriteria::amplitude_over_sigma(const SinusoidFit& fit, std::size_t k) const {
  return amplitude_over_sigma(fit, k, &ChannelFit::covariance);
}

bool ModeCriteria::is_lone_and_sure(const SinusoidFit& fit, std::size_t k) const {
  return fit.poles.size() == 1 &&
         amplitude_over_sigma(fit, k, &ChannelFit::covariance_at_poles) > kSureAmplitudeSigmas;
}

double ModeCriteria::amplitude_over_sigma(const SinusoidFit& fit,
                                          std::size_t k,
                                          Eigen::MatrixXd ChannelFit::*which) const {
  double out = 0.0;
  const double variance = std::max(fit.variance(), 1e-300);
  for (const ChannelFit& channel : fit.channels) {
    const Eigen::MatrixXd& covariance = channel.*which;
    const auto i = static_cast<Index>(k);
    const Index column = covariance.rows() - 2 * channel.cosine.size() + 2 * i;
    const Eigen::Vector2d x(channel.cosine(i), channel.sine(i));
    const double amplitude = x.norm();
    if (!(amplitude > 0.0)) continue;
    const Eigen::Vector2d direction = x / amplitude;
    const double spread =
        direction.dot(covariance.block<2, 2>(column, column) * direction) * variance;
    out = std::max(out, amplitude / std::sqrt(std::max(spread, 1e-300)));
  }
  return out;
}

double ModeCriteria::duration_s() const {
  double out = 1e-300;
  for (const SampleSeries& s : m_series) out = std::max(out, s.time_s(s.time_s.size() - 1));
  return out;
}

std::vector<std::size_t> ModeCriteria::by_energy(const SinusoidFit& fit) const {
  std::vector<std::size_t> order(fit.poles.size());
  std::iota(order.begin(), order.end(), 0U);
  std::vector<double> energies;
  for (const std::size_t k : order) energies.push_back(energy(fit, k));
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return energies[a] < energies[b];
  });
  return order;
}

double ModeCriteria::energy(const SinusoidFit& fit, std::size_t k) const {
  // sum A² exp(-2 d t) / 2 over evenly spread samples.
  double out = 0.0;
  for (std::size_t c = 0; c < m_series.size(); ++c) {
    const VectorXd& t = m_series[c].time_s;
    const double duration = std::max(t(t.size() - 1), 1e-300);
    const double exponent = std::max(2.0 * fit.poles[k].decay_per_s * duration, -60.0);
    const double mean = std::abs(exponent) < 1e-6 ? 1.0 : -std::expm1(-exponent) / exponent;
    out +=
        0.5 * std::pow(m_scale[c] * fit.amplitude(c, k), 2) * mean * static_cast<double>(t.size());
  }
  return out;
}

}  // namespace twang
