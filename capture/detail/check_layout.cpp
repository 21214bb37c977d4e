// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/check_layout.hpp"

#include "capture/marker_pattern.hpp"
#include "core/error.hpp"
#include "core/text.hpp"

#include <fmt/format.h>

#include <vector>

namespace twang::detail {

void check_markers(const Rig& rig) {
  if (rig.markers.empty() || !rig.camera) {
    throw InputError(fmt::format("{}: has no {}, must have [[marker]] and [camera] to be tracked",
                                 rig.file.empty() ? "rig '" + rig.name + "'" : rig.file.string(),
                                 rig.markers.empty() ? "[[marker]]" : "[camera]"));
  }
  for (const Marker& marker : rig.markers) {
    try {
      static_cast<void>(MarkerPattern(marker));
    } catch (const InputError& error) {
      throw InputError(fmt::format(
          "{}: {}", rig.file.empty() ? "rig '" + rig.name + "'" : rig.file.string(), error.what()));
    }
  }
}

void check_starts(const LumaFrame& frame,
                  const Rig& rig,
                  const std::map<std::string, Eigen::Vector2d>& start_px) {
  for (const auto& [id, px] : start_px) {
    if (!rig.find_marker(id)) {
      std::vector<std::string> ids;
      for (const Marker& marker : rig.markers) ids.push_back(marker.id);
      throw InputError(fmt::format(
          "--marker {}: the rig has no such marker, must be one of its ids (nearest: '{}')",
          id,
          nearest_word(id, ids)));
    }
    const bool inside = px.x() >= 0.0 && px.y() >= 0.0 && px.x() <= frame.width_px - 1 &&
                        px.y() <= frame.height_px - 1;
    if (!inside) {
      throw InputError(
          fmt::format("--marker {}={},{}: lies outside the picture, must be within "
                      "{} x {} pixels",
                      id,
                      px.x(),
                      px.y(),
                      frame.width_px,
                      frame.height_px));
    }
  }
}

}  // namespace twang::detail
