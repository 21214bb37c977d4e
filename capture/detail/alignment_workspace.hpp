// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/alignment_kernels.hpp"

#include <cstddef>
#include <memory>

namespace twang::detail {

/// The arrays that a window's pixels need.
class AlignmentWorkspace {
 public:
  [[nodiscard]] const ModelSamples& samples() const { return m_samples; }
  [[nodiscard]] float* residual() { return at(10); }
  [[nodiscard]] float* square_slope() { return at(11); }
  void reserve(int pixels) {
    const int room = (pixels + kAlignmentBlock - 1) / kAlignmentBlock * kAlignmentBlock;
    if (room > m_room) {
      // Filled by whoever uses them: zeros would be written for nothing.
      m_floats = std::make_unique_for_overwrite<float[]>(12 * static_cast<std::size_t>(room) +
                                                         2 * kMargin);
      m_room = room;
    }
    m_samples.room = room;
    m_samples = {at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7), at(8), at(9), room};
  }

 private:
  float* at(int array) {
    return m_floats.get() + kMargin + static_cast<std::ptrdiff_t>(array) * m_samples.room;
  }
  static constexpr int kMargin = 16;  // floats that may be read before and behind the arrays
  std::unique_ptr<float[]> m_floats;
  int m_room = 0;  // of the arrays there are
  ModelSamples m_samples;
};

}  // namespace twang::detail
