// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/progress.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/refine_sinusoids.hpp"
#include "harmonic_inversion/sample_scatter.hpp"

#include <string>
#include <vector>

namespace twang {

struct SelectionOptions {
  Band band_hz;
  double step_s = 0.0;                ///< usual distance of two samples [s]
  double false_alarm_rate = 0.003;    ///< chance that white noise is given a mode [-]
  double max_damping_ratio = 0.75;    ///< above it nothing oscillates [-]
  double max_decay_per_sample = 1.5;  ///< d dt above it: gone within a sample [-]
  int max_candidates = 24;            ///< poles of one proposal that are looked at
  ProgressCallback progress = {};
  void check() const;
};

/// Which damped sinusoids a signal supports.
struct ModeSelection {
  SinusoidFit fit;               ///< in the channels' units; covariances for unit variance
  std::vector<bool> is_growing;  ///< one a pole: fitted, but no decay, so not a mode
  std::vector<double> errors;    ///< one a pole: relative distance of the finder's pole to the fit
  std::vector<RejectedMode> rejected;
  std::string finder;  ///< whose proposal won
  int num_outliers = 0;
  std::vector<std::vector<bool>> is_outlier;  ///< one a channel and sample: left out of the fit
  std::vector<SampleScatter> scatter;         ///< one a channel: by it the samples were weighed
  std::vector<int> num_down_weighted;         ///< one a channel: of a part of their weight
  double moment_mismatch = 0.0;  ///< largest of the channels, see `WeightedData::moment_mismatch`
};

/// Chooses the number of damped sinusoids and fits them.
///
/// Starts from the proposal with the lowest Bayes information criterion, then adds the sinusoid
/// that explains most of the residual and drops what is not supported, until neither is worth it.
/// A mode stays if all hold:
///   - the criterion `n ln(RSS / n) + p ln n` falls by it;
///   - under white noise a gain as large is rarer than `false_alarm_rate` anywhere in the band;
///   - it lies in the band, oscillates, and outlives a sample;
///   - it is not a heavily damped trifle beside a strong mode (a moving baseline, a transient);
///   - where it overlaps a stronger one, it explains much more than a slight change of that mode
///     with amplitude would.
/// Channels are weighted by their own noise and samples by their stated standard deviations;
/// isolated outliers are left out. Where some in short runs are seen, or several modes in a short
/// record may stand for them, it is done again from the strongest mode on with outliers counting
/// less (see `robust_factors`), and what has the lower criterion is kept, a run of outliers having
/// an unknown each and two for its place, as a mode has four. So it is where outliers are seen and
/// no mode.
///
/// What is chosen is least squares less its bias of second order, see `without_bias`.
[[nodiscard]] ModeSelection select_modes(const std::vector<SampleSeries>& series,
                                         const SelectionOptions& options);

}  // namespace twang
