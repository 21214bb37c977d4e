// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/file_part.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace twang {
namespace {

/// The elements of one material.
HexMesh elements_of(const HexMesh& mesh, int material) {
  HexMesh part;
  part.kind = mesh.kind;
  part.nodes = mesh.nodes;
  std::vector<Eigen::Index> own;
  for (int e = 0; e < mesh.num_elements(); ++e) {
    if (mesh.material_of_element[static_cast<std::size_t>(e)] == material) own.push_back(e);
  }
  part.elements = mesh.elements(Eigen::all, own);
  part.material_of_element.assign(own.size(), 0);
  return part;
}

SurfaceFile surface_of(const HexMesh& mesh, const MeshFile& file) {
  SurfaceFile surface;
  surface.file = file.file;
  const auto faces = surface_faces(mesh);
  surface.vertices = mesh.nodes;
  surface.triangles.resize(3, 2 * static_cast<Eigen::Index>(faces.size()));
  Eigen::Index next = 0;
  for (const std::array<int, 4>& face : faces) {
    // The diagonal begins at the lowest number: materials that share a face cut it alike.
    const auto first =
        static_cast<std::size_t>(std::min_element(face.begin(), face.end()) - face.begin());
    const auto corner = [&](std::size_t i) { return face[(first + i) % 4]; };
    surface.triangles.col(next++) = Eigen::Vector3i(corner(0), corner(1), corner(2));
    surface.triangles.col(next++) = Eigen::Vector3i(corner(0), corner(2), corner(3));
  }
  Box box;
  box.min = box.max = mesh.nodes.col(surface.triangles(0, 0));
  for (Eigen::Index i = 0; i < surface.triangles.size(); ++i) {
    const Eigen::Vector3d x = mesh.nodes.col(surface.triangles(i));
    box.min = box.min.cwiseMin(x);
    box.max = box.max.cwiseMax(x);
  }
  surface.box = box;
  return surface;
}

}  // namespace

Rig with_surfaces_of(const Rig& rig, const HexMesh& mesh) {
  Rig result = rig;
  result.meshing.file.reset();
  result.parts.clear();
  for (std::size_t m = 0; m < mesh.material_names.size(); ++m) {
    result.parts.push_back({mesh.material_names[m],
                            surface_of(elements_of(mesh, static_cast<int>(m)), *rig.meshing.file)});
  }
  return result;
}

}  // namespace twang
