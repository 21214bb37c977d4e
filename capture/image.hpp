// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace twang {

/// An 8-bit picture, rows from the top, `channels` interleaved (1: grey, 3: red green blue).
///
/// Pixel coordinates: (0, 0) is the *centre* of the upper left pixel, x to the right, y down [px].
struct Image {
  int width_px = 0;
  int height_px = 0;
  int channels = 1;
  std::vector<std::uint8_t> pixels;  ///< (height x width x channels)
};

}  // namespace twang
