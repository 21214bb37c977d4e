// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/compare_blocks.hpp"

#include <cassert>
#include <cstddef>
#include <cstdlib>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace twang::detail {
namespace {

constexpr std::size_t kBlocksPerLine = 4;  // of memory, as a processor fetches it

#ifdef __SSE2__

/// The two halves that `_mm_sad_epu8` leaves, added.
std::uint32_t total(__m128i halves) {
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(halves) +
                                    _mm_cvtsi128_si32(_mm_unpackhi_epi64(halves, halves)));
}

BlockSums compare_block(const std::uint8_t* now,
                        std::ptrdiff_t stride,
                        int rows,
                        std::uint8_t* kept) {
  const __m128i zero = _mm_setzero_si128();
  __m128i light = zero;
  __m128i change = zero;
  __m128i equal = zero;  // rows in which a column's pixels are
  for (int row = 0; row < rows; ++row) {
    auto* before = reinterpret_cast<__m128i*>(kept + kBlock_px * row);
    const __m128i a = _mm_loadu_si128(reinterpret_cast<const __m128i*>(now + row * stride));
    const __m128i b = _mm_loadu_si128(before);
    light = _mm_add_epi64(light, _mm_sad_epu8(a, zero));
    change = _mm_add_epi64(change, _mm_sad_epu8(a, b));
    equal = _mm_sub_epi8(equal, _mm_cmpeq_epi8(a, b));
    _mm_storeu_si128(before, a);
  }
  const auto pixels = static_cast<std::uint32_t>(kBlock_px * rows);
  return {total(light), total(change), pixels - total(_mm_sad_epu8(equal, zero))};
}

#else

BlockSums compare_block(const std::uint8_t* now,
                        std::ptrdiff_t stride,
                        int rows,
                        std::uint8_t* kept) {
  BlockSums sums;
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i < kBlock_px; ++i) {
      const std::uint8_t pixel = now[row * stride + i];
      std::uint8_t& before = kept[kBlock_px * row + i];
      sums.light += pixel;
      sums.change += static_cast<std::uint32_t>(std::abs(pixel - before));
      sums.unequal += pixel != before ? 1 : 0;
      before = pixel;
    }
  }
  return sums;
}

#endif

}  // namespace

void compare_blocks(const std::uint8_t* now,
                    std::ptrdiff_t stride,
                    int rows,
                    std::uint8_t* kept,
                    std::vector<BlockSums>& blocks) {
  assert(rows >= 0 && rows <= kBlock_px);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (i % kBlocksPerLine == 0) {
      for (int row = rows; row < 2 * rows; ++row) __builtin_prefetch(now + row * stride);
    }
    blocks[i] = compare_block(now, stride, rows, kept);
    now += kBlock_px;
    kept += kBlock_px * rows;
  }
}

}  // namespace twang::detail
