// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

namespace twang {

struct VideoWriterOptions {
  double fps = 30.0;                           ///< > 0; stamps are n / fps [1/s]
  int crf = 18;                                ///< H.264 constant rate factor, 0 (lossless) to 51
  std::optional<double> capture_fps_tag = {};  ///< written as `com.android.capture.fps` in mp4 and
                                               ///< mov, as slow-motion cameras do [1/s]
  bool quick = false;  ///< a film to be looked at: takes a fraction of the time and more room
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// The planes of a picture to be painted: luma, and in half the width and height what blue and red
/// have more than it, 128 being none. Rows from the top; both sizes of the luma plane are even.
struct PicturePlanes {
  std::uint8_t* luma = nullptr;
  std::uint8_t* blue = nullptr;
  std::uint8_t* red = nullptr;
  std::ptrdiff_t luma_stride = 0;    ///< bytes from one row to the next
  std::ptrdiff_t chroma_stride = 0;  ///< of both
  int width_px = 0;                  ///< of the luma plane [px]
  int height_px = 0;                 ///< [px]
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
  /// Appends a picture that `paint` fills, all of it: what it finds there has no meaning. Saves the
  /// way over an image of its own.
  /// @throws InputError if the disk is full
  void write(const std::function<void(const PicturePlanes&)>& paint);
  /// Flushes the encoder and puts the file in its place; nothing may be written afterwards.
  /// @throws InputError if no picture was written, or the disk is full
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

}  // namespace twang
