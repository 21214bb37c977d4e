// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/picture_shape.hpp"

#include <fmt/format.h>

#include <cmath>

namespace twang::detail {

void make_square(std::vector<MarkerTrack>& tracks, double pixel_aspect) {
  if (pixel_aspect == 1.0) return;
  for (MarkerTrack& track : tracks) {
    for (auto& px : track.position_px) px.x() *= pixel_aspect;
    for (double& sigma : track.sigma_px) sigma *= std::sqrt(pixel_aspect);
  }
}

std::vector<Note> notes_on_pictures(const VideoInfo& info) {
  std::vector<Note> notes;
  if (info.pixel_aspect != 1.0) {
    notes.emplace_back(
        fmt::format("The file says that its pixels are not square, {:.5g} times as wide as high: "
                    "{} x {} px are shown as {:.0f} x {}, and measured so.",
                    info.pixel_aspect,
                    info.width_px,
                    info.height_px,
                    info.pixel_aspect * info.width_px,
                    info.height_px));
  }
  if (info.interlaced) {
    notes.emplace_back(
        "The film is interlaced: even and odd rows of a picture are half a frame apart in time, so "
        "what moves is combed and its positions are means over both; film progressively.",
        Severity::Warning);
  }
  return notes;
}

}  // namespace twang::detail
