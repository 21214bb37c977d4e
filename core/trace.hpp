// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace twang {

/// One named column of a trace; the unit is the name's suffix (`tip.x_mm`, `observable_rad`).
struct Channel {
  std::string name;
  std::vector<double> values;  ///< one a sample, nan where lost, doubled or doubtful
};

/// A table over time, as it stands in a trace file: one row a decoded frame.
///
/// A trace is a *file's* content, so its columns keep the file's units; what computes on it
/// converts by suffix.
struct Trace {
  std::vector<double> time_s;     ///< strictly increasing, 0 at the first frame of a film [s]
  std::vector<Channel> channels;  ///< each as long as time_s

  [[nodiscard]] std::size_t num_samples() const { return time_s.size(); }
  /// The channel of that name, or nullptr.
  [[nodiscard]] const Channel* find(std::string_view name) const;
  [[nodiscard]] Channel* find(std::string_view name);
  /// How much later than `time_s` a channel was sampled: `tip.time_offset_s` for `tip.x_mm`,
  /// `observable.time_offset_s` for `observable_mm`; nullptr if it was sampled then. [s]
  [[nodiscard]] const Channel* time_offset_of(std::string_view name) const;
  /// The standard deviations of a channel's samples: `tip.sigma_mm` for `tip.x_mm`,
  /// `observable.sigma_mm` for `observable_mm`, `y.sigma_v` for `y` and `y.a_v`; nullptr if none
  /// are stated. In the channel's unit.
  [[nodiscard]] const Channel* sigma_of(std::string_view name) const;
  /// Number of samples of `channel` that are finite.
  [[nodiscard]] static std::size_t num_finite(const Channel& channel);
};

}  // namespace twang
