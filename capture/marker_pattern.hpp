// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

namespace twang {

/// The ideal picture of a marker, as printed: 0 where it is ink, 1 where it is paper.
///
/// One definition serves finding, aligning and rendering. Coordinates are in units of the outer
/// size, centred, x right, y down: the pattern fills [-1/2, 1/2]². Outside it is paper.
///
///     cross     two bars across the whole size, each a third of the size wide
///     dot       a filled disk of diameter 1
///     ring      a disk of diameter 1 with a hole of diameter 1/2
///     checker   a square of side 1, its upper left and lower right quadrants ink
///
/// @throws InputError for kinds whose picture is not known (aruco, apriltag, patch)
[[nodiscard]] double pattern_value(MarkerKind kind, double x, double y);

/// The same, area-averaged over a square of side `width` around (x, y): what a pixel of that size
/// sees. Values 0..1. Cost: a few evaluations near an edge, one elsewhere.
[[nodiscard]] double pattern_value_averaged(MarkerKind kind, double x, double y, double width);

/// Angle after which the pattern repeats under rotation; 0 where every turn looks the same (dot,
/// ring) [rad].
[[nodiscard]] double rotational_period_rad(MarkerKind kind);

}  // namespace twang
