// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/video_reader.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace twang::detail {

/// Finds pictures that repeat the one before.
///
/// A repeat changes nothing: neither what moves nor the sensor's noise. The picture is cut into
/// blocks; of each frame the mean change of the typical block (noise) and of the most changed block
/// (motion) are kept. A frame is a repeat if its most changed block hardly changed while before and
/// after it those did, and its noise is missing too, where the film has noise that can be missed.
/// Where the film has none, a frame taken symmetrically about a turning point of the motion looks
/// the same and goes with them: a sample less, not a wrong one.
class DoubledFrames {
 public:
  /// Takes the film's next picture.
  void add(const LumaFrame& frame);
  struct Verdict {
    std::vector<bool> doubled;  ///< for each frame, whether it repeats the one before
    std::vector<bool> changed;  ///< whether it clearly does not
  };
  [[nodiscard]] Verdict decide() const;

 private:
  std::vector<std::uint8_t> m_before;
  std::vector<double> m_typical;  // mean absolute change of the median block [grey levels]
  std::vector<double> m_largest;  // of the most changed block [grey levels]
};

/// Finds repeats that the blocks do not show, in slow motion, from a marker's track: frames in
/// which it did not move although the frames around it say that it should have.
///
/// @param position_px  one a frame; nan where lost [px]
/// @return  one a frame: 1 it stands where it should have moved, -1 it moved, 0 nothing can be said
[[nodiscard]] std::vector<int> stands_against_motion(
    const std::vector<Eigen::Vector2d>& position_px, const std::vector<double>& sigma_px);

}  // namespace twang::detail
