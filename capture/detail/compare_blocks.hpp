// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace twang::detail {

/// Sums over 16 pixels in a row, or over the rows of a block.
struct BlockSums {
  std::uint32_t light = 0;    ///< of the later picture [grey levels]
  std::uint32_t change = 0;   ///< absolute difference of the two [grey levels]
  std::uint32_t unequal = 0;  ///< pixels that differ
};

inline constexpr int kBlock_px = 16;

/// Adds the comparison of two rows of pixels to that of the blocks they cross; a last block that is
/// not full is left out. Cost: 16 pixels an instruction where the processor can (SSE2).
void compare_rows(const std::uint8_t* now,
                  const std::uint8_t* before,
                  int width_px,
                  std::vector<BlockSums>& blocks);

}  // namespace twang::detail
