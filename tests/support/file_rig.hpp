// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"
#include "fem/vtu.hpp"
#include "rigs/rig.hpp"
#include "tests/support/temporary_folder.hpp"

namespace twang::test {

/// A rig whose part is the mesh of another rig, in a file.
struct FileRig {
  FileRig(const Rig& solid, double dx_m) : rig(solid) {
    write_vtu(folder / "part.vtu", mesh_part(solid, dx_m, ElementKind::Hex8), {});
    rig.parts.clear();
    rig.meshing.file = MeshFile{};
    rig.meshing.file->file = folder / "part.vtu";
    rig.meshing.file->metres_per_unit = 1.0;
  }
  TemporaryFolder folder;
  Rig rig;
};

}  // namespace twang::test
