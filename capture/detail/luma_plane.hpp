// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/ffmpeg.hpp"
#include "capture/video_reader.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace twang::detail {

/// How a player turns the pictures of a stream: quarter turns and reflections.
///
/// A stored pixel (x, y) is shown at (right · (x, y), down · (x, y)) plus what brings the picture
/// into its frame.
struct Orientation {
  std::array<int, 2> right = {1, 0};
  std::array<int, 2> down = {0, 1};

  [[nodiscard]] bool upright() const { return right[0] == 1 && down[1] == 1; }
  [[nodiscard]] bool swaps_sides() const { return right[0] == 0; }
  /// Clockwise, of a picture that is not mirrored [deg].
  [[nodiscard]] int turn_deg() const;
};

/// The orientation a stream's display matrix asks for; upright if it has none, or one that is no
/// multiple of a quarter turn.
[[nodiscard]] Orientation orientation_of(const AVStream& stream);

/// Whether the pictures of a pixel format carry luma as whole samples of 8 to 16 bits.
[[nodiscard]] bool has_luma(int pixel_format);

/// Hands on the luma of decoded pictures: as it lies in memory if it is 8-bit and upright, else
/// from a buffer, rounded to 8 bits and turned as a player shows it.
class LumaPlane {
 public:
  explicit LumaPlane(Orientation orientation = {}) : m_orientation(orientation) {}
  /// @param picture  of a format that has luma
  [[nodiscard]] LumaFrame view(const AVFrame& picture);

 private:
  void unpack(const AVFrame& picture);
  void turn(const LumaFrame& stored);

  Orientation m_orientation;
  std::vector<std::uint8_t> m_unpacked;
  std::vector<std::uint8_t> m_turned;
};

}  // namespace twang::detail
