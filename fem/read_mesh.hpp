// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"

namespace twang {

/// Reads a mesh of hexahedra of 8 or of 20 nodes, scaled and moved as `file` says: Gmsh `.msh`
/// (ASCII, format 2.2 or 4.1) or VTK `.vtu` (ASCII or binary, compressed by zlib or not).
///
/// `material_names` are the groups: in `.msh` the physical volumes by name, else by number; in
/// `.vtu` the numbers of the cell array "material", "gmsh:physical" or "MaterialIds". Elements
/// without one are in the group "". Points, lines and faces are skipped, nodes that no element has
/// are left out.
///
/// @throws InputError naming the file (and the line of a text file) if it cannot be read, is cut
/// short, holds other solid elements, a number that is not finite or a node that does not exist, or
/// if its elements do not hang together
[[nodiscard]] HexMesh read_mesh(const MeshFile& file);

/// The mesh with elements of another kind: mid-edge nodes are put midway, or left out.
[[nodiscard]] HexMesh with_kind(const HexMesh& mesh, ElementKind kind);

/// Reads the rig's mesh file, each group as the material that the rig names for it, or of its own
/// name; a rig of one material needs no groups.
/// @throws InputError as `read_mesh`, and for a group without a material
[[nodiscard]] HexMesh read_mesh_of(const Rig& rig, ElementKind kind);

}  // namespace twang
