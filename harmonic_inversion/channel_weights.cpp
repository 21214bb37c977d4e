// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/channel_weights.hpp"

#include <fmt/format.h>

#include <utility>

namespace twang {
namespace {

std::string describe(const ChannelWeights& weights) {
  const std::string stated =
      fmt::format("The samples of {} are weighed by {}", weights.channel, weights.sigma_column);
  if (weights.extra_sigma > 0.0) {
    return fmt::format("{}; they scatter by {:.3g} beyond it.", stated, weights.extra_sigma);
  }
  return fmt::format("{}; they scatter {:.3g} times as much.", stated, weights.sigma_factor);
}

}  // namespace

void describe_weights(const InversionWindow& window,
                      const ModeSelection& selection,
                      InversionResult& out) {
  for (std::size_t c = 0; c < window.series.size(); ++c) {
    ChannelWeights weights;
    weights.channel = window.series[c].name;
    weights.sigma_column = window.sigma_columns[c];
    const bool weighed = !weights.sigma_column.empty();
    if (weighed) weights.sigma_factor = selection.scatter[c].factor;
    weights.extra_sigma = selection.scatter[c].extra;
    if (weighed) out.remarks.push_back(describe(weights));
    out.weights.push_back(std::move(weights));
  }
  if (selection.num_outliers > 0) {
    out.notes.push_back(
        fmt::format("{} isolated sample{} far off the model took no part in the fit.",
                    selection.num_outliers,
                    selection.num_outliers == 1 ? "" : "s"));
  }
}

}  // namespace twang
