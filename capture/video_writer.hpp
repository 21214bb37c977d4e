// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"

#include <filesystem>
#include <memory>
#include <optional>

namespace twang {

struct VideoWriterOptions {
  double fps = 30.0;  ///< > 0; stamps are n / fps [1/s]
  int crf = 18;       ///< H.264 constant rate factor, 0 (lossless) to 51
};

/// Writes an H.264 film frame by frame (FFmpeg, libx264, yuv420p; full-range luma is kept as
/// given). The container follows from the extension: mp4, mov, mkv.
///
/// The file appears whole with `finish` or not at all.
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

  /// Appends a picture of the film's size, grey or RGB.
  void write(const Image& image);
  /// Flushes the encoder and puts the file in its place.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

}  // namespace twang
