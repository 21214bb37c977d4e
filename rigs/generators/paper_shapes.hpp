// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/surface_mesh.hpp"

#include <string>
#include <utility>
#include <vector>

namespace twang {

// Shapes after those of Chen, Levin, Matusik, Kaufman, SIGGRAPH 2017, as closed surfaces [m]. What
// its figures show at 1.5 mm a voxel is kept to a voxel; the depth, which they do not show, is
// 24 mm along y.

/// Base, an upright leg 1.5 mm thick and a thick arm on it: 5408 cells of 1.5 mm, as many as its
/// table counts.
[[nodiscard]] SurfaceMesh jumper();
/// The same on a base that widens upwards over its feet.
[[nodiscard]] SurfaceMesh flipper_body();
/// The feet of the flipper: steps at both ends, of a soft material.
[[nodiscard]] SurfaceMesh flipper_feet();
/// The flipper, feet included, with a basket on the arm's free end.
[[nodiscard]] SurfaceMesh catapult();
/// Foot and stem of a plant of 1 cm³, as many cells as its table counts at 0.1 mm.
[[nodiscard]] SurfaceMesh plant_stem();
/// Five pairs of folded leaves that begin within the knots of the stem, 0.6 mm thick: one voxel of
/// the coarse mesh in its table, between whose voxels their faces lie.
[[nodiscard]] SurfaceMesh plant_leaves();
/// Foot, one thin leg, body, and an S-shaped neck with head and beak.
[[nodiscard]] std::vector<SurfaceMesh> flamingo();
/// A back with a hump and a head on four legs with knees and flat soles, 3 mm thick throughout: two
/// voxels of 1.5 mm.
[[nodiscard]] SurfaceMesh walker();

/// All of them by the name of their file.
[[nodiscard]] std::vector<std::pair<std::string, SurfaceMesh>> paper_shapes();

}  // namespace twang
