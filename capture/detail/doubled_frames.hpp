// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/video_reader.hpp"

#include <cstdint>
#include <vector>

namespace twang::detail {

/// Finds pictures that repeat the one before.
///
/// A repeat changes nothing: neither what moves nor the sensor's noise. The picture is cut into
/// blocks; of each frame the mean change of the typical block (noise) and of the most changed block
/// (motion) are kept. A frame is a repeat if, against the frames around it, its most changed block
/// hardly changed while those did, and its noise is missing too, where the film has noise that can
/// be missed.
class DoubledFrames {
 public:
  /// Takes the film's next picture.
  void add(const LumaFrame& frame);
  /// For each frame taken, whether it repeats the one before.
  [[nodiscard]] std::vector<bool> decide() const;

 private:
  std::vector<std::uint8_t> m_before;
  std::vector<double> m_typical;  // mean absolute change of the median block [grey levels]
  std::vector<double> m_largest;  // of the most changed block [grey levels]
};

}  // namespace twang::detail
