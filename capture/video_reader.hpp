// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace twang {

/// What the container says of a film before a frame is decoded.
struct VideoInfo {
  int width_px = 0;                    ///< as a player shows it, turned by its rotation tag [px]
  int height_px = 0;                   ///< [px]
  double tick_s = 0.0;                 ///< time base of the stamps [s]
  std::optional<double> declared_fps;  ///< average rate the container declares [1/s]
  std::optional<double>
      capture_fps_tag;  ///< rate at which the camera says it filmed (Android, Apple) [1/s]
  std::optional<long> declared_frames;  ///< number of frames that the container holds and shows
  std::string codec;
  int stored_width_px = 0;   ///< as the camera's rows and columns lie in the file [px]
  int stored_height_px = 0;  ///< [px]
  int rotation_deg = 0;      ///< clockwise, by which the stored picture is turned: 0, 90, 180, 270
  Eigen::Vector2i turned_right = {1, 0};  ///< a step right in the shown picture, in the stored one
  Eigen::Vector2i turned_down = {0, 1};   ///< a step down; rows are read out along the stored +y
  bool interlaced = false;  ///< rows of two moments in one picture, by the container's word or that
                            ///< of a picture read so far
  double pixel_aspect = 1.0;  ///< width of a pixel over its height, of the shown picture [-]
};

/// One decoded picture; the view is valid until the next call of `read`.
struct LumaFrame {
  const std::uint8_t* pixels = nullptr;  ///< luma plane, row after row (height x stride)
  std::ptrdiff_t stride = 0;             ///< bytes from one row to the next
  int width_px = 0;
  int height_px = 0;
  double stamp_s = 0.0;  ///< presentation time of the packet [s]; nan if the file has none
  long coded_bytes = 0;  ///< what the picture takes up in the file; 0 if unknown
  char coded_as = '?';   ///< 'I' by itself, 'P' from pictures before, 'B' from both sides; '?'
};

/// Reads a film from beginning to end, luma plane only, decoded on several threads (FFmpeg).
///
/// Opening it runs once through its packets, without decoding, so that a film that is cut off is
/// refused before any work is done on it. What an edit list cuts away is not shown. Where a program
/// has stamped pictures in order of decoding instead of presentation, the order is restored.
/// Pictures come as a player shows them: turned by quarters or mirrored where the file says so.
/// Luma of more than 8 bits is rounded to 8; its levels are handed on as stored, limited or full
/// range. An 8-bit plane that is not turned is not copied.
class VideoReader {
 public:
  /// @throws InputError naming the file if it does not exist, is no film, ends before its index or
  /// its stated duration does, has no picture stream, a codec that is not known or no luma
  explicit VideoReader(const std::filesystem::path& path);
  ~VideoReader();
  VideoReader(const VideoReader&) = delete;
  VideoReader& operator=(const VideoReader&) = delete;

  [[nodiscard]] const VideoInfo& info() const;
  /// The next picture, in order of presentation; nothing at the end.
  /// @throws InputError if the film breaks off (a truncated file) or a picture cannot be decoded;
  /// says after which frame
  [[nodiscard]] std::optional<LumaFrame> read();

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

}  // namespace twang
