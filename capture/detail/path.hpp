// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

namespace twang::detail {

/// What a frame's moment shows in: one coordinate of one marker [px], or the light [grey levels].
struct Path {
  std::vector<double> y;     ///< one a frame; nan where lost
  double floor = 0.0;        ///< least error of a sample
  double least_range = 0.0;  ///< below it nothing moves
  double stood = 0.0;        ///< most between two codings of one picture
  double copied = 0.0;       ///< most that coders leave out of a picture as if it were a repeat
  [[nodiscard]] double at(std::size_t n) const { return y[n]; }
};

}  // namespace twang::detail
