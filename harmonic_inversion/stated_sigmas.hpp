// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/trace.hpp"

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// The standard deviations that a trace states of one channel's samples.
///
/// @param column  the column that holds them; empty: the one that the trace has for the channel,
///                see `Trace::sigma_of`, and none if that holds no number at all
/// @return        nullptr if none are stated; a value that is not finite says that the sample's is
///                not known
/// @throws InputError if a column named is absent or holds no number, or a sample that is finite
///                has a standard deviation of 0 or below
[[nodiscard]] const Channel* stated_sigmas(const Trace& trace,
                                           const Channel& channel,
                                           const std::string& column);

/// A trace in which the samples of unknown standard deviation are nan, and how many there were.
struct KnownSamples {
  std::optional<Trace> trace;  ///< nothing if there are none
  std::vector<std::string> notes;
};
/// @param channels       in the trace
/// @param sigma_columns  see `sigma_column_of`
/// @throws InputError as `stated_sigmas`
[[nodiscard]] KnownSamples without_unknown_sigmas(const Trace& trace,
                                                  const std::vector<std::string>& channels,
                                                  const std::vector<std::string>& sigma_columns);

/// The entry of `sigma_columns` that belongs to channel `c`: one for all, or one each.
[[nodiscard]] std::string sigma_column_of(const std::vector<std::string>& sigma_columns,
                                          std::size_t c);

}  // namespace twang
