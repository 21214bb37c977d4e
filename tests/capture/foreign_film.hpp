// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace twang::test {

/// A film as other programs make them, with all that can be odd about it.
struct ForeignFilm {
  std::string codec = "libx264";         ///< FFmpeg's name of the encoder
  std::string pixel_format = "yuv420p";  ///< FFmpeg's name
  std::vector<std::int64_t> stamps;      ///< of the pictures, ascending [1 / ticks_per_s]
  int ticks_per_s = 15360;
  bool faststart = false;        ///< the index at the beginning of an mp4
  bool reordering_lost = false;  ///< packets stamped in order of decoding
};

/// Writes it, 64 x 48 px; picture n has luma `picture_level(n)` everywhere.
void write_foreign_film(const std::filesystem::path& path, const ForeignFilm& film);
/// Level of picture n, different for neighbours and over the first 180 pictures.
[[nodiscard]] int picture_level(int n);

/// Writes a file with sound alone.
void write_sound_file(const std::filesystem::path& path);

/// FFmpeg's name of the range of levels that a film's first picture is tagged with: "tv", "pc"
/// (full), "unknown".
[[nodiscard]] std::string colour_range_of(const std::filesystem::path& path);

/// The pixels of a PNG image of the expected pixel format, row after row, as FFmpeg decodes them.
[[nodiscard]] std::vector<std::uint8_t> decode_png(std::vector<std::uint8_t> bytes,
                                                   const std::string& pixel_format);

}  // namespace twang::test
