// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/paint_picture.hpp"
#include "core/progress.hpp"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>

namespace twang::detail {

/// Which frames of a film are painted, and what is said meanwhile.
struct FilmPainting {
  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  std::size_t first = 0;     ///< frame of the film
  std::size_t count = kAll;  ///< so many from there on, or all
  double fps = 0.0;          ///< of the painted film [1/s]
  std::string stage;         ///< what the progress is called
};

/// Paints frame `n` of the film in grey, `frame`, which is in `picture` already.
using PaintFrame = std::function<void(Picture& picture, const LumaFrame& frame, std::size_t n)>;

/// Writes a film beside a film: each of its frames in grey, painted.
/// @throws InputError if the film cannot be read or has fewer frames; Cancelled
void paint_film(const std::filesystem::path& video,
                const std::filesystem::path& painted,
                const FilmPainting& painting,
                const PaintFrame& paint,
                const ProgressCallback& progress);

}  // namespace twang::detail
