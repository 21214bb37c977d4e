// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

#include <Eigen/Core>

namespace twang {

/// The triangles of a surface.
struct SurfaceMesh {
  Eigen::Matrix3Xd vertices;   ///< (3 x vertices), rig frame [m]
  Eigen::Matrix3Xi triangles;  ///< (3 x triangles), indices of vertices, as oriented in the file
};

/// Reads an STL (binary or ASCII) or OBJ file, scales and moves it as `surface` says; a surface in
/// memory is returned as it is.
///
/// The vertices of an STL file are not merged: each triangle has three of its own. Polygons of an
/// OBJ file are cut into fans.
///
/// @throws InputError naming the file (and the line of a text file) if it cannot be read, is of
/// another kind, is cut short, has no triangle or holds a coordinate that is not finite
[[nodiscard]] SurfaceMesh read_surface(const SurfaceFile& surface);

/// Smallest box around the triangles, of which there must be one [m].
[[nodiscard]] Box bounds_of(const SurfaceMesh& surface);

/// Writes a surface as binary STL in millimetres, whole or not at all.
/// @throws InputError if the file cannot be written
void write_stl(const std::filesystem::path& path, const SurfaceMesh& surface);

}  // namespace twang
