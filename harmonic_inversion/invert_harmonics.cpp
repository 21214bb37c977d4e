// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/invert_harmonics.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "harmonic_inversion/amplitude_dependence.hpp"
#include "harmonic_inversion/channel_weights.hpp"
#include "harmonic_inversion/evaluate_modes.hpp"
#include "harmonic_inversion/inversion_window.hpp"
#include "harmonic_inversion/select_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string_view>
#include <utility>

namespace twang {
namespace {

using Eigen::Index;

/// The default band, in parts of 1 / duration and of Nyquist.
constexpr double kLowestCycles = 1.5;
constexpr double kHighestPartOfNyquist = 0.98;
/// Above this part of the sampling rate a mode is said to be possibly an alias.
constexpr double kAliasPart = 0.4;
/// A fit on moments and one on all samples have the same sum of squares but for this part of it,
/// which moves no sigma by more than half as much; round-off leaves 1e-5 at the most.
constexpr double kMomentMismatch = 1e-3;
/// Neighbouring residuals correlated above this say that the residual is not noise.
constexpr double kColouredResidual = 0.4;

/// The band that is reported.
Band choose_band(const InversionOptions& options, const InversionWindow& window) {
  const double nyquist = 0.5 / window.step_s;
  if (!options.band_hz) {
    return {std::min(kLowestCycles / window.duration_s, 0.5 * nyquist),
            kHighestPartOfNyquist * nyquist};
  }
  if (options.band_hz->low_hz >= nyquist) {
    throw InputError(
        fmt::format("InversionOptions.band_hz.low_hz is {}, must be below Nyquist, {:.6g} Hz",
                    options.band_hz->low_hz,
                    nyquist));
  }
  return {options.band_hz->low_hz, std::min(options.band_hz->high_hz, nyquist)};
}

/// The band that is modelled: a strong mode outside the reported one must not pass for noise.
Band widen_band(const Band& band, const InversionWindow& window) {
  const Band all = choose_band({}, window);
  return {std::min(band.low_hz, all.low_hz), std::max(band.high_hz, all.high_hz)};
}

/// Amplitude, phase and their sigmas of pole k in channel c.
SinusoidInChannel in_channel(const SinusoidFit& fit,
                             std::size_t c,
                             std::size_t k,
                             const std::string& name) {
  const ChannelFit& channel = fit.channels[c];
  const auto i = static_cast<Index>(k);
  // A sin(wt + theta) = A sin(theta) cos(wt) + A cos(theta) sin(wt).
  const Eigen::Vector2d x(channel.cosine(i), channel.sine(i));
  SinusoidInChannel out;
  out.channel = name;
  out.amplitude = x.norm();
  out.phase_rad = std::atan2(x(0), x(1));
  if (out.phase_rad <= -kPi) out.phase_rad = kPi;
  const Index column = channel.covariance.rows() - 2 * channel.cosine.size() + 2 * i;
  const Eigen::Matrix2d covariance =
      channel.covariance.block<2, 2>(column, column) * fit.variance();
  if (out.amplitude > 0.0) {
    const Eigen::Vector2d radial = x / out.amplitude;
    const Eigen::Vector2d along(radial(1), -radial(0));
    out.amplitude_sigma = std::sqrt(std::max(radial.dot(covariance * radial), 0.0));
    out.phase_sigma_rad = std::sqrt(std::max(along.dot(covariance * along), 0.0)) / out.amplitude;
  }
  return out;
}

DampedSinusoid to_mode(const ModeSelection& selection,
                       std::size_t k,
                       const std::vector<std::string>& names) {
  const SinusoidFit& fit = selection.fit;
  const auto i = 2 * static_cast<Index>(k);
  const double variance = fit.variance();
  DampedSinusoid mode;
  mode.frequency_hz = fit.poles[k].frequency_hz;
  mode.decay_per_s = fit.poles[k].decay_per_s;
  mode.frequency_sigma_hz = std::sqrt(fit.pole_covariance(i, i) * variance);
  mode.decay_sigma_per_s = std::sqrt(fit.pole_covariance(i + 1, i + 1) * variance);
  mode.frequency_decay_covariance = fit.pole_covariance(i, i + 1) * variance;
  mode.error = selection.errors[k];
  for (std::size_t c = 0; c < names.size(); ++c) {
    mode.channels.push_back(in_channel(fit, c, k, names[c]));
  }
  return mode;
}

double joint_amplitude(const DampedSinusoid& mode) {
  double sum = 0.0;
  for (const SinusoidInChannel& channel : mode.channels)
    sum += channel.amplitude * channel.amplitude;
  return std::sqrt(sum);
}

void reject(const DampedSinusoid& mode, std::string_view reason, InversionResult& out) {
  RejectedMode& rejected = out.rejected.emplace_back();
  rejected.frequency_hz = mode.frequency_hz;
  rejected.decay_per_s = mode.decay_per_s;
  rejected.reason = reason;
}

/// Splits the fitted poles into modes, strongest first, and the rest with reasons.
void collect_modes(const ModeSelection& selection,
                   const Band& band,
                   int max_modes,
                   InversionResult& out) {
  for (std::size_t k = 0; k < selection.fit.poles.size(); ++k) {
    DampedSinusoid mode = to_mode(selection, k, out.channel_names);
    if (selection.is_growing[k]) {
      reject(mode, "grows instead of decaying", out);
      out.notes.push_back(
          fmt::format("The motion at {:.4g} Hz grows by {:.3g} 1/s: it is driven or unstable, not "
                      "a free decay.",
                      mode.frequency_hz,
                      -mode.decay_per_s));
      continue;
    }
    if (mode.frequency_hz < band.low_hz || mode.frequency_hz > band.high_hz) {
      reject(mode, "outside the band asked for", out);
      continue;
    }
    out.modes.push_back(std::move(mode));
  }
  std::stable_sort(out.modes.begin(), out.modes.end(), [](const auto& a, const auto& b) {
    return joint_amplitude(a) > joint_amplitude(b);
  });
  while (max_modes > 0 && out.modes.size() > static_cast<std::size_t>(max_modes)) {
    reject(out.modes.back(), "weaker than the modes asked for", out);
    out.modes.pop_back();
  }
}

/// Residual of what is reported, its root sum of squares over the channels, and its colour.
void measure_residual(const std::vector<SampleSeries>& series,
                      const std::vector<std::vector<bool>>& is_outlier,
                      InversionResult& out) {
  double sum = 0.0;
  double power = 0.0;
  double neighbours = 0.0;
  for (std::size_t c = 0; c < series.size(); ++c) {
    const SampleSeries& s = series[c];
    const Eigen::VectorXd model = evaluate_modes(out, c, s.time_s);
    double squares = 0.0;
    double before = 0.0;
    int used = 0;
    for (Index i = 0; i < s.value.size(); ++i) {
      if (is_outlier[c][static_cast<std::size_t>(i)]) continue;
      const double r = s.value(i) - model(i);
      squares += r * r;
      neighbours += r * before;
      before = r;
      ++used;
    }
    out.num_samples += used;
    sum += squares / std::max(used, 1);
    power += squares;
  }
  out.residual_rms = std::sqrt(sum);
  if (out.modes.empty()) return;
  const double strongest = joint_amplitude(out.modes.front());
  out.snr_db = 20.0 * std::log10(strongest / out.residual_rms);
  const bool measurable = out.residual_rms > 1e-9 * strongest;
  if (measurable && neighbours > kColouredResidual * power) {
    out.notes.push_back(fmt::format(
        "The residual is not white (correlation of neighbours {:.2f}): the model leaves "
        "something out, and the sigmas, which count noise alone, are too small.",
        neighbours / power));
  }
}

void add_mismatch_note(double mismatch, InversionResult& out) {
  if (!(mismatch > kMomentMismatch)) return;
  out.notes.push_back(
      fmt::format("The fit was made on moments of the record, whose sum of squares is off that of "
                  "all its samples by {:.2g} of it: the result is not to be trusted.",
                  mismatch));
}

void add_alias_notes(double rate_hz, InversionResult& out) {
  for (const DampedSinusoid& mode : out.modes) {
    if (mode.frequency_hz <= kAliasPart * rate_hz) continue;
    out.notes.push_back(fmt::format(
        "The mode at {:.5g} Hz lies above 0.4 of the sampling rate of {:.5g} Hz: it may "
        "be the alias of one at {:.5g} Hz.",
        mode.frequency_hz,
        rate_hz,
        std::abs(rate_hz - mode.frequency_hz)));
  }
}

void add_overlap_notes(InversionResult& out) {
  for (std::size_t k = 0; k < out.modes.size(); ++k) {
    for (std::size_t j = k + 1; j < out.modes.size(); ++j) {
      const DampedSinusoid& a = out.modes[k];
      const DampedSinusoid& b = out.modes[j];
      const double width = (a.decay_per_s + b.decay_per_s) / kTwoPi;
      if (std::abs(a.frequency_hz - b.frequency_hz) >= width) continue;
      out.notes.push_back(fmt::format(
          "The modes at {:.5g} and {:.5g} Hz overlap: they may be one whose frequency or "
          "damping changes with amplitude.",
          a.frequency_hz,
          b.frequency_hz));
    }
  }
}

std::string describe(const InversionResult& out) {
  if (out.modes.empty()) {
    return fmt::format(
        "no mode: nothing in {} samples from {:.4g} to {:.4g} s stands out as a decaying "
        "oscillation",
        out.num_samples,
        out.time_origin_s,
        out.time_end_s);
  }
  const DampedSinusoid& mode = out.modes.front();
  return fmt::format(
      "{} mode{}, the strongest at {:.5g} Hz with a decay of {:.4g} 1/s (damping ratio {:.3g}), "
      "{:.0f} dB over the residual",
      out.modes.size(),
      out.modes.size() == 1 ? "" : "s",
      mode.frequency_hz,
      mode.decay_per_s,
      mode.damping_ratio(),
      out.snr_db);
}

std::string describe_method(const ModeSelection& selection, const InversionResult& out) {
  if (selection.fit.poles.empty()) return "no pole passed the tests";
  return fmt::format(
      "{}, then least squares of all poles on the time stamps with an offset{} per channel; {} "
      "pole{} "
      "by the Bayes information criterion and a false-alarm bound",
      selection.finder,
      std::any_of(
          out.drifts_per_s.begin(), out.drifts_per_s.end(), [](double d) { return d != 0.0; })
          ? " and a drift"
          : "",
      selection.fit.poles.size(),
      selection.fit.poles.size() == 1 ? "" : "s");
}

InversionResult invert(const InversionWindow& window, const InversionOptions& options) {
  InversionResult out;
  for (std::size_t c = 0; c < window.series.size(); ++c) {
    out.channel_names.push_back(window.series[c].name);
  }
  out.channel_origins_s = window.origins_s;
  out.time_origin_s = window.origins_s.front();
  out.time_end_s = window.end_s;
  out.release_s = window.release_s;
  out.remarks = window.notes;

  const Band band = choose_band(options, window);
  SelectionOptions selecting;
  selecting.band_hz = widen_band(band, window);
  selecting.step_s = window.step_s;
  selecting.progress = options.progress;
  const ModeSelection selection = select_modes(window.series, selecting);

  out.rejected = selection.rejected;
  for (const ChannelFit& channel : selection.fit.channels) {
    out.offsets.push_back(channel.offset);
    out.drifts_per_s.push_back(channel.drift_per_s);
  }
  collect_modes(selection, band, options.max_modes, out);
  measure_residual(window.series, selection.is_outlier, out);
  describe_weights(window, selection, out);
  add_mismatch_note(selection.moment_mismatch, out);
  add_alias_notes(1.0 / window.step_s, out);
  add_overlap_notes(out);
  AmplitudeDependence dependence = amplitude_dependence(window.series, window.num_traces, out);
  out.amplitude_windows = std::move(dependence.windows);
  if (!dependence.sentence.empty()) out.notes.push_back(std::move(dependence.sentence));
  out.method = describe_method(selection, out);
  out.termination = selection.fit.termination;
  out.message = describe(out);
  return out;
}

}  // namespace

void InversionOptions::check() const {
  if (band_hz) {
    if (!(band_hz->low_hz >= 0.0 && std::isfinite(band_hz->low_hz))) {
      throw InputError(fmt::format("InversionOptions.band_hz.low_hz is {}, must be finite and >= 0",
                                   band_hz->low_hz));
    }
    if (!(band_hz->high_hz > band_hz->low_hz && std::isfinite(band_hz->high_hz))) {
      throw InputError(
          fmt::format("InversionOptions.band_hz.high_hz is {}, must be finite and above low_hz, {}",
                      band_hz->high_hz,
                      band_hz->low_hz));
    }
  }
  if (start_s && !std::isfinite(*start_s)) {
    throw InputError(fmt::format("InversionOptions.start_s is {}, must be finite", *start_s));
  }
  if (end_s && !std::isfinite(*end_s)) {
    throw InputError(fmt::format("InversionOptions.end_s is {}, must be finite", *end_s));
  }
  if (start_s && end_s && !(*end_s > *start_s)) {
    throw InputError(
        fmt::format("InversionOptions.end_s is {}, must be after start_s, {}", *end_s, *start_s));
  }
  if (max_modes < 0) {
    throw InputError(fmt::format("InversionOptions.max_modes is {}, must be >= 0", max_modes));
  }
}

double InversionResult::origin_s(std::size_t channel) const {
  return channel < channel_origins_s.size() ? channel_origins_s[channel] : time_origin_s;
}

double InversionResult::evaluate(std::size_t channel, double time_s) const {
  const double t = time_s - origin_s(channel);
  double value = offsets[channel] + drifts_per_s[channel] * t;
  for (const DampedSinusoid& mode : modes) {
    const SinusoidInChannel& part = mode.channels[channel];
    value += part.amplitude * std::exp(-mode.decay_per_s * t) *
             std::sin(kTwoPi * mode.frequency_hz * t + part.phase_rad);
  }
  return value;
}

double InversionResult::evaluate_rate(std::size_t channel, double time_s) const {
  const double t = time_s - origin_s(channel);
  double rate = 0.0;
  for (const DampedSinusoid& mode : modes) {
    const SinusoidInChannel& part = mode.channels[channel];
    const double omega = kTwoPi * mode.frequency_hz;
    const double angle = omega * t + part.phase_rad;
    rate += part.amplitude * std::exp(-mode.decay_per_s * t) *
            (omega * std::cos(angle) - mode.decay_per_s * std::sin(angle));
  }
  return rate;
}

InversionResult invert_harmonics(const Trace& trace,
                                 const std::vector<std::string>& channels,
                                 const InversionOptions& options) {
  options.check();
  return invert(choose_window({&trace, 1}, channels, options), options);
}

InversionResult invert_repeats(const std::vector<Trace>& traces,
                               const std::vector<std::string>& channels,
                               const InversionOptions& options) {
  options.check();
  return invert(choose_window(traces, channels, options), options);
}

std::vector<std::string> default_columns(const Trace& trace) {
  std::vector<std::string> observables;
  std::vector<std::string> all;
  for (const Channel& channel : trace.channels) {
    const std::string& name = channel.name;
    if (name.rfind("observable_", 0) == 0) observables.push_back(name);
    if (name.find(".sigma_") != std::string::npos) continue;
    if (name.find(".time_offset_s") != std::string::npos) continue;
    all.push_back(name);
  }
  return observables.empty() ? all : observables;
}

}  // namespace twang
