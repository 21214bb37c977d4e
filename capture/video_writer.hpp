// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"

#include <filesystem>
#include <memory>
#include <optional>

namespace twang {

struct VideoWriterOptions {
  double fps = 30.0;                           ///< > 0; stamps are n / fps [1/s]
  int crf = 18;                                ///< H.264 constant rate factor, 0 (lossless) to 51
  std::optional<double> capture_fps_tag = {};  ///< written as `com.android.capture.fps` in mp4 and
                                               ///< mov, as slow-motion cameras do [1/s]
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// Writes an H.264 film frame by frame (FFmpeg, libx264, yuv420p; full-range luma is kept as
/// given). The container follows from the extension: mp4, mov, mkv.
///
/// The file appears whole with `finish` or not at all. A film of odd width or height is one pixel
/// larger, its last column or row repeated: H.264 pairs pixels.
class VideoWriter {
 public:
  /// @throws InputError if the container is not known or the file cannot be written
  VideoWriter(const std::filesystem::path& path,
              int width_px,
              int height_px,
              VideoWriterOptions options);
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// Appends a picture of the film's size, grey or RGB (turned into full-range BT.601).
  /// @throws InputError if it has another size, or the disk is full
  void write(const Image& image);
  /// Flushes the encoder and puts the file in its place; nothing may be written afterwards.
  /// @throws InputError if no picture was written, or the disk is full
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

}  // namespace twang
