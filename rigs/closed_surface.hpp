// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/surface_mesh.hpp"

#include <string>
#include <vector>

namespace twang {

/// A surface that encloses a solid: every edge is passed as often one way as the other, normals
/// point out of the solid.
struct ClosedSurface {
  SurfaceMesh mesh;        ///< equal vertices merged, triangles without three corners left out
  double volume_m3 = 0.0;  ///< sum of a·(b × c) / 6; what is enclosed twice counts twice [m³]
  int num_shells = 0;      ///< pieces that no edge connects; a cavity is one
  std::vector<std::string> notes;  ///< what was mended, a sentence each, naming the file
};

/// Merges vertices and turns triangles until the surface encloses a solid.
///
/// Vertices are merged where they are equal; if that leaves holes, where they are within a
/// millionth of the surface's size. Triangles that face another way than their neighbours are
/// turned, then shells that face inwards without lying in another; notes say so. Shells may cross:
/// a point is inside if the surface winds around it, once or more.
///
/// @param name  of the file, for messages
/// @throws InputError if an edge belongs to an odd number of triangles (a hole, a wall inside), the
/// surface has one side only, or it encloses nothing. O(n log n).
[[nodiscard]] ClosedSurface close_surface(const SurfaceMesh& surface, const std::string& name);

/// Reads a surface file and closes it.
/// @throws InputError as `read_surface` and `close_surface`
[[nodiscard]] ClosedSurface read_closed_surface(const SurfaceFile& file);

/// a·(b × c) / 6 summed over the triangles [m³].
[[nodiscard]] double enclosed_volume(const SurfaceMesh& surface);

}  // namespace twang
