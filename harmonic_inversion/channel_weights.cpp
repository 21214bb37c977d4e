// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/channel_weights.hpp"

#include <fmt/format.h>

#include <algorithm>
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
  int num_left_out = 0;
  int num_down_weighted = 0;
  for (std::size_t c = 0; c < window.series.size(); ++c) {
    ChannelWeights weights;
    weights.channel = window.series[c].name;
    weights.sigma_column = window.sigma_columns[c];
    const bool weighed = !weights.sigma_column.empty();
    if (weighed) weights.sigma_factor = selection.scatter[c].factor;
    weights.extra_sigma = selection.scatter[c].extra;
    const std::vector<bool>& left_out = selection.is_outlier[c];
    weights.num_left_out = static_cast<int>(std::count(left_out.begin(), left_out.end(), true));
    weights.num_down_weighted = selection.num_down_weighted[c];
    if (weighed) out.remarks.push_back(describe(weights));
    num_left_out += weights.num_left_out;
    num_down_weighted += weights.num_down_weighted;
    out.weights.push_back(std::move(weights));
  }
  const auto samples = [](int count) {
    return fmt::format("{} sample{} far off the model", count, count == 1 ? "" : "s");
  };
  if (num_left_out > 0) {
    out.notes.push_back(samples(num_left_out) + " took no part in the fit.");
  }
  if (num_down_weighted > 0) {
    out.notes.push_back(samples(num_down_weighted) + " counted less in the fit.");
  }
}

}  // namespace twang
