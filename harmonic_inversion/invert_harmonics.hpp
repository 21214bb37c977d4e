// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/damped_sinusoid.hpp"
#include "core/progress.hpp"
#include "core/termination.hpp"
#include "core/trace.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace twang {

/// Lower and upper frequency [Hz].
struct Band {
  double low_hz = 0.0;
  double high_hz = 0.0;
};

struct InversionOptions {
  std::optional<Band> band_hz;  ///< absent: 1.5 / duration to 0.98 Nyquist
  /// Absent: after the release if one is seen, else the first sample. Given while the part is still
  /// held or pulled, it moves to the free motion after the release, and a note says so [s]
  std::optional<double> start_s;
  /// Absent: the last sample, or the next disturbance after the release [s]
  std::optional<double> end_s;
  int max_modes = 0;  ///< strongest kept; 0: all that the data support
  ProgressCallback progress = {};
  /// Columns with the standard deviations of the samples, one a channel or one for all; empty:
  /// those that the trace has for them, see `Trace::sigma_of`. A sample whose own is nan counts as
  /// missing.
  std::vector<std::string> sigma_columns = {};
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// A candidate that was not kept, and why.
struct RejectedMode {
  double frequency_hz = 0.0;
  double decay_per_s = 0.0;
  std::string reason;
};

/// The strongest mode in a part of a recording.
struct AmplitudeWindow {
  std::size_t recording = 0;  ///< of those inverted together
  double start_s = 0.0;       ///< first and
  double end_s = 0.0;         ///< last sample used [s]
  double amplitude = 0.0;     ///< in the middle, root sum of squares over the channels, their unit
  double frequency_hz = 0.0;
  double frequency_sigma_hz = kNaN;
  double decay_per_s = 0.0;
  double decay_sigma_per_s = kNaN;
};

/// The strongest mode by another method, see `check_decay`.
struct DecayCheck {
  std::string method;          ///< "logarithmic decrement" or "Morlet wavelet"
  std::string channel;         ///< the one looked at
  double frequency_hz = kNaN;  ///< nan where it found none
  double frequency_sigma_hz = kNaN;
  double decay_per_s = kNaN;
  double decay_sigma_per_s = kNaN;
  int num_points = 0;   ///< on the straight line
  std::string message;  ///< why there is no value; empty where there is one

  [[nodiscard]] bool usable() const { return message.empty(); }
};

/// How the samples of a channel were weighed:
///
///     1 / weight² = (sigma_factor sigma_i)² + extra_sigma²                  (see SampleScatter)
struct ChannelWeights {
  std::string channel;
  std::string sigma_column;    ///< of sigma_i; empty: none, or all are the same
  double sigma_factor = kNaN;  ///< 1 where the residual is larger than sigma_i say [-]
  double extra_sigma = kNaN;   ///< scatter beyond sigma_i, in the channel's unit
  int num_left_out = 0;        ///< outliers that took no part in the fit
  int num_down_weighted = 0;   ///< outliers of a part of their weight
};

/// What harmonic inversion found in one or several channels that share their poles.
///
///     y_c(t) = offset_c + sum_k A_kc exp(-d_k (t - t0)) sin(2 pi f_k (t - t0) + theta_kc),   t0 =
///     time_origin_s
struct InversionResult {
  std::vector<DampedSinusoid> modes;  ///< strongest first, by amplitude at t0
  double time_origin_s = kNaN;        ///< t0, the first sample used [s]
  double time_end_s = kNaN;           ///< the last sample used [s]
  std::optional<double> release_s;    ///< when the free motion was seen to begin [s]
  std::vector<std::string> channel_names;
  std::vector<double> channel_origins_s;  ///< t0 of each channel; empty: time_origin_s [s]
  std::vector<double> offsets;            ///< one a channel, in its unit, at t0
  std::vector<double> drifts_per_s;       ///< slow linear drift, one a channel, 0 where not fitted
  double residual_rms = kNaN;             ///< root sum of squares over the channels, in their unit
  double snr_db = kNaN;                   ///< 20 log10(A1 / residual_rms) [dB]
  int num_samples = 0;                    ///< finite samples used, all channels
  std::string method;  ///< how the modes were found and how many the data support
  std::vector<RejectedMode> rejected;
  std::vector<std::string> notes;  ///< alias twins, growing modes ...: one sentence each
  Termination termination = Termination::NotRun;
  std::string message;               ///< one sentence for a person
  std::vector<std::string> remarks;  ///< how the window was chosen: one sentence each
  /// The strongest mode while its amplitude falls, see `amplitude_dependence`.
  std::vector<AmplitudeWindow> amplitude_windows;
  std::vector<DecayCheck> decay_checks;  ///< filled by those who ask for them, see `check_decay`
  std::vector<ChannelWeights> weights;   ///< one a channel

  [[nodiscard]] bool usable() const { return !modes.empty(); }
  /// The time origin of a channel: its entry in `channel_origins_s`, else `time_origin_s` [s].
  [[nodiscard]] double origin_s(std::size_t channel) const;
  /// The model's value in channel `channel` at `time_s`.
  [[nodiscard]] double evaluate(std::size_t channel, double time_s) const;
  /// Its time derivative, without the drift: the velocity of the vibration [unit/s].
  [[nodiscard]] double evaluate_rate(std::size_t channel, double time_s) const;
};

/// Finds the damped sinusoids of a trace: filter diagonalization [Mandelshtam & Taylor 1997] for
/// the poles, then least squares on the real time stamps for all parameters together, with their
/// covariance. Where the trace says by how much a channel was sampled later than its rows (a
/// rolling shutter, see `Trace::time_offset_of`), those are the stamps, and t0 is the first row's.
/// Where it states the samples' standard deviations, they are the weights, see `ChannelWeights`.
///
/// @param channels  names of channels of `trace`; several share their poles, each has its own
/// amplitudes
/// @throws InputError if a channel is missing, fewer than 8 of its samples are finite, the trace is
/// empty, or an option
///         is out of range; Cancelled
[[nodiscard]] InversionResult invert_harmonics(const Trace& trace,
                                               const std::vector<std::string>& channels,
                                               const InversionOptions& options = {});

/// The same over several traces of one part (repeats): all share their poles, each trace has its
/// own window, time origin and amplitudes.
///
/// @param channels  looked up in every trace; in the result they are called `<n>:<name>`, n = 1 ...
[[nodiscard]] InversionResult invert_repeats(const std::vector<Trace>& traces,
                                             const std::vector<std::string>& channels,
                                             const InversionOptions& options = {});

/// The columns that are inverted when none is named: `observable_*` if there, else all but
/// `*.sigma_*` and
/// `*.time_offset_s`.
[[nodiscard]] std::vector<std::string> default_columns(const Trace& trace);

/// The result as JSON text, format `twang-modes/1`; what is not finite is `null`.
[[nodiscard]] std::string modes_to_json(const InversionResult& result);
/// Several columns inverted one by one: `{"format": "twang-modes/1", "columns": {name: {...}}}`.
[[nodiscard]] std::string modes_to_json(
    const std::vector<std::pair<std::string, InversionResult>>& columns);

}  // namespace twang
