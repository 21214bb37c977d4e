// SPDX-License-Identifier: GPL-3.0-or-later
// Sums of residuals, several pixels at a time. Part of alignment_kernels_impl.hpp, in the namespace
// of its instruction set: see there.
#pragma once

#include "capture/detail/alignment_kernels.hpp"
#include "capture/detail/template_lookup_impl.hpp"

namespace twang::detail::TWANG_KERNEL_NAMESPACE {
namespace {

inline double total(Lanes values) {
  float sum = 0.0F;
  for (int lane = 0; lane < kLanes; ++lane) sum += values[lane];
  return static_cast<double>(sum);
}

/// The sums of one row: in single precision, since a row is short.
struct RowSums {
  Lanes count = {}, square = {}, grey = {}, model = {};
  Lanes grey_grey = {}, model_model = {}, grey_model = {};
  Lanes flat = {}, flat_square = {}, beside = {}, num_beside = {}, below = {}, num_below = {};

  void add_to(ResidualSums& sums) const {
    sums.count += total(count), sums.square += total(square);
    sums.grey += total(grey), sums.model += total(model);
    sums.grey_grey += total(grey_grey), sums.model_model += total(model_model);
    sums.grey_model += total(grey_model);
    sums.flat += total(flat), sums.flat_square += total(flat_square);
    sums.beside += total(beside), sums.num_beside += total(num_beside);
    sums.below += total(below), sums.num_below += total(num_below);
  }
};

/// Sums over the window's pixels, row by row. What is read beyond a row's end, or before the first
/// pixel, counts for nothing.
ResidualSums sum_up(const AlignmentWindow& window,
                    const ModelSamples& samples,
                    const JudgedPixels& judged,
                    const float* residual,
                    const float* square_slope) {
  const Lanes zero = {};
  const Lanes one = zero + 1.0F;
  IntLanes lane = {};
  for (int i = 0; i < kLanes; ++i) lane[i] = i;
  const auto is_flat = [&](int i) {
    return (load(samples.weight + i) >= judged.least_weight) &
           (load(square_slope + i) < judged.steep);
  };
  ResidualSums sums;
  for (int y = 0; y < window.height; ++y) {
    RowSums row;
    for (int x = 0; x < window.width; x += kLanes) {
      const int i = y * window.width + x;
      const IntLanes within = lane < window.width - x;
      const IntLanes counts = within & (load(samples.weight + i) >= judged.least_weight);
      const Lanes r = counts ? load(residual + i) : zero;
      const Lanes grey = counts ? load(samples.grey + i) - judged.middle : zero;
      const Lanes model = grey - r;
      row.count += counts ? one : zero;
      row.square += r * r;
      row.grey += grey;
      row.model += model;
      row.grey_grey += grey * grey;
      row.model_model += model * model;
      row.grey_model += grey * model;
      const IntLanes flat = within & is_flat(i);
      row.flat += flat ? one : zero;
      row.flat_square += flat ? r * r : zero;
      const IntLanes pair = flat & is_flat(i - 1) & (lane + x > 0);
      row.num_beside += pair ? one : zero;
      row.beside += pair ? r * load(residual + i - 1) : zero;
      if (y == 0) continue;
      const IntLanes column = flat & is_flat(i - window.width);
      row.num_below += column ? one : zero;
      row.below += column ? r * load(residual + i - window.width) : zero;
    }
    row.add_to(sums);
  }
  return sums;
}

}  // namespace
}  // namespace twang::detail::TWANG_KERNEL_NAMESPACE
