// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

#include <string>
#include <vector>

namespace twang {

/// Where a marker is printed on its page, from the page's upper left corner.
struct PrintedMarker {
  std::string id;
  int page = 0;             ///< from 0
  double centre_x_m = 0.0;  ///< to the right [m]
  double centre_y_m = 0.0;  ///< down [m]
};

/// The markers of a rig, ready to be printed, cut out and glued on.
struct MarkerSheet {
  std::vector<std::string> pages;        ///< SVG, one A4 page each
  std::vector<PrintedMarker> markers;    ///< in the rig's order; without those not printed
  std::vector<std::string> not_printed;  ///< ids of patches: natural texture, nothing to print
};

/// Lays the markers out on A4 pages, true to scale: lengths in the SVG are millimetres. Each has a
/// white margin of a quarter of its size all around, which the tracker expects, with thin lines to
/// cut along, its name and its size; each page has a ruler to check the printer's scale by.
///
/// The shapes are those of `marker_pattern.hpp`, as vectors.
///
/// @throws InputError if the rig has no marker to print or one that does not fit on a page
[[nodiscard]] MarkerSheet draw_marker_sheet(const Rig& rig);

}  // namespace twang
