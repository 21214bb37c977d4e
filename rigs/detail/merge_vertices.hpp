// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/surface_mesh.hpp"

namespace twang::detail {

/// The same surface with vertices merged that are equal (`tolerance_m` 0) or no farther apart than
/// that along any axis; triangles that lose a corner thereby are left out, unused vertices too.
[[nodiscard]] SurfaceMesh merge_vertices(const SurfaceMesh& surface, double tolerance_m);

}  // namespace twang::detail
