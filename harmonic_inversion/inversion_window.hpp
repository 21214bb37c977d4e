// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/damped_pole.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace twang {

/// The samples that an inversion works on.
struct InversionWindow {
  std::vector<SampleSeries> series;  ///< one a trace and channel
  std::size_t num_traces = 0;        ///< the series of one stand together
  std::vector<double>
      origins_s;            ///< time origin of each series: the first row used in its trace [s]
  double end_s = 0.0;       ///< last sample of the first trace used [s]
  double step_s = 0.0;      ///< usual distance of two samples [s]
  double duration_s = 0.0;  ///< of the longest series [s]
  std::optional<double> release_s;  ///< of the first trace [s]
  std::vector<std::string> notes;
  std::vector<std::string> sigma_columns;  ///< by which each series is weighed; empty: by none
};

/// Chooses the free motion in each trace and cuts the channels to it.
///
/// A channel that `Trace::time_offset_of` says was sampled later than its rows gets its own times;
/// origins, ends and the window stay those of the rows.
///
/// A start given in `options` that falls before a release moves to the free motion after it.
/// @throws InputError as `invert_harmonics`
[[nodiscard]] InversionWindow choose_window(std::span<const Trace> traces,
                                            const std::vector<std::string>& channels,
                                            const InversionOptions& options);

}  // namespace twang
