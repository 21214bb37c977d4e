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

#ifdef __SSE2__

/// The two halves that `_mm_sad_epu8` leaves, added.
std::uint32_t total(__m128i halves) {
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(halves) +
                                    _mm_cvtsi128_si32(_mm_unpackhi_epi64(halves, halves)));
}

void add_pixels(const std::uint8_t* now, const std::uint8_t* before, BlockSums& sums) {
  const __m128i a = _mm_loadu_si128(reinterpret_cast<const __m128i*>(now));
  const __m128i b = _mm_loadu_si128(reinterpret_cast<const __m128i*>(before));
  const __m128i zero = _mm_setzero_si128();
  const __m128i equal = _mm_and_si128(_mm_cmpeq_epi8(a, b), _mm_set1_epi8(1));
  sums.light += total(_mm_sad_epu8(a, zero));
  sums.change += total(_mm_sad_epu8(a, b));
  sums.unequal += kBlock_px - total(_mm_sad_epu8(equal, zero));
}

#else

void add_pixels(const std::uint8_t* now, const std::uint8_t* before, BlockSums& sums) {
  for (int i = 0; i < kBlock_px; ++i) {
    sums.light += now[i];
    sums.change += static_cast<std::uint32_t>(std::abs(now[i] - before[i]));
    sums.unequal += now[i] != before[i] ? 1 : 0;
  }
}

#endif

}  // namespace

void compare_rows(const std::uint8_t* now,
                  const std::uint8_t* before,
                  int width_px,
                  std::vector<BlockSums>& blocks) {
  const auto columns = static_cast<std::size_t>(width_px / kBlock_px);
  assert(blocks.size() >= columns);
  for (std::size_t i = 0; i < columns; ++i) {
    add_pixels(now + kBlock_px * i, before + kBlock_px * i, blocks[i]);
  }
}

}  // namespace twang::detail
