// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/stated_sigmas.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <cmath>

namespace twang {

const Channel* stated_sigmas(const Trace& trace,
                             const Channel& channel,
                             const std::string& column) {
  const Channel* sigma = column.empty() ? trace.sigma_of(channel.name) : trace.find(column);
  if (sigma == nullptr && column.empty()) return nullptr;
  if (sigma == nullptr) {
    throw InputError(
        fmt::format("column {}, named for the standard deviations of {}, is not in the trace",
                    column,
                    channel.name));
  }
  if (Trace::num_finite(*sigma) == 0) {
    if (column.empty()) return nullptr;
    throw InputError(fmt::format(
        "column {} holds no number, expected the standard deviations of {}", column, channel.name));
  }
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    if (!std::isfinite(channel.values[i]) || !(sigma->values[i] <= 0.0)) continue;
    throw InputError(
        fmt::format("column {} is {} at {:.9g} s (row {}), expected a standard deviation above 0, "
                    "or nan where it is not known",
                    sigma->name,
                    sigma->values[i],
                    trace.time_s[i],
                    i + 1));
  }
  return sigma;
}

KnownSamples without_unknown_sigmas(const Trace& trace,
                                    const std::vector<std::string>& channels,
                                    const std::vector<std::string>& sigma_columns) {
  KnownSamples out;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const Channel& channel = *trace.find(channels[c]);
    const Channel* sigma = stated_sigmas(trace, channel, sigma_column_of(sigma_columns, c));
    if (sigma == nullptr) continue;
    std::size_t count = 0;
    for (std::size_t i = 0; i < trace.num_samples(); ++i) {
      if (!std::isfinite(channel.values[i]) || std::isfinite(sigma->values[i])) continue;
      if (!out.trace) out.trace = trace;
      out.trace->find(channels[c])->values[i] = kNaN;
      ++count;
    }
    if (count == 0) continue;
    out.notes.push_back(
        fmt::format("{} sample{} of {} without a standard deviation in {} count{} as missing.",
                    count,
                    count == 1 ? "" : "s",
                    channels[c],
                    sigma->name,
                    count == 1 ? "s" : ""));
  }
  return out;
}

std::string sigma_column_of(const std::vector<std::string>& sigma_columns, std::size_t c) {
  if (sigma_columns.empty()) return "";
  return sigma_columns.size() == 1 ? sigma_columns.front() : sigma_columns[c];
}

}  // namespace twang
