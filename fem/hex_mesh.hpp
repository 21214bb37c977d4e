// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"
#include "fem/hexahedron.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

namespace twang {

/// A mesh of hexahedra.
struct HexMesh {
  ElementKind kind = ElementKind::Hex8;
  Eigen::Matrix3Xd nodes;                ///< (3 x num_nodes) [m]
  Eigen::MatrixXi elements;              ///< (nodes_per_element x num_elements), VTK order
  std::vector<int> material_of_element;  ///< index into material_names
  std::vector<std::string> material_names;
  double requested_dx_m = 0.0;  ///< [m]
  Eigen::Vector3d actual_dx_m =
      Eigen::Vector3d::Zero();  ///< cell size of a voxel mesh, x, y, z [m]
  Eigen::VectorXd fill;       ///< volume of the part in an element over the element's; empty: 1 [-]
  Eigen::VectorXd mass_fill;  ///< by what its material's density is multiplied; empty: 1 [-]
  Eigen::VectorXd stiffness_fill;  ///< by what its material's stiffness is; empty: 1 [-]
  double part_volume_m3 = kNaN;    ///< of the part it stands for, if that is known [m³]
  std::vector<std::string> notes;  ///< what was mended or lost, a sentence each

  [[nodiscard]] int num_nodes() const { return static_cast<int>(nodes.cols()); }
  [[nodiscard]] int num_elements() const { return static_cast<int>(elements.cols()); }
  [[nodiscard]] int num_dofs() const { return 3 * num_nodes(); }
  /// Sum of the elements' volumes by quadrature, as far as they are filled [m³].
  [[nodiscard]] double volume() const;
};

/// Cuts the rig's part into equal cells and fills those whose centre lies in a solid.
///
/// Per axis the bounding box is cut into max(1, round(length / dx)) cells, so the part keeps its
/// size. A later solid overrides an earlier one's material. Nodes are numbered along the axis with
/// the most cells last, shared between neighbours; hex20 adds mid-edge nodes.
///
/// With `rig.meshing.partial_cells`, cells are filled that the part fills to a twentieth or more,
/// and the mass of the part is kept: each has the mass of what is in it and in its nearly empty
/// neighbours, and its share of the stiffness if wanted. With `rig.meshing.file` the mesh is read
/// from there and dx plays no role.
///
/// @throws InputError if dx <= 0, the rig has no part, a solid vanishes or the mesh falls apart at
/// this dx (both name the solid and a dx that would do), there would be more than 50 million cells,
/// or a surface or mesh file cannot be used
[[nodiscard]] HexMesh mesh_part(const Rig& rig, double dx_m, ElementKind kind);

/// How many cells of which size hold more than one material.
struct MaterialMixing {
  Eigen::Vector3d actual_dx_m = Eigen::Vector3d::Zero();  ///< [m]
  long num_cells = 0;                                     ///< that the part reaches
  long num_mixed = 0;  ///< of these, with more than a hundredth of each of two materials
};

/// Whether the cells of a mesh of this dx would each hold one material: a mesh is as coarse as one
/// material per element allows where none is mixed.
/// @throws InputError if dx <= 0, the rig has no solid, or a surface file cannot be used
[[nodiscard]] MaterialMixing count_mixed_cells(const Rig& rig, double dx_m);

/// Nodes that a clamp holds: those within a thousandth of a cell of its box, ascending.
/// @throws InputError if a clamp holds no node
[[nodiscard]] std::vector<int> clamped_nodes(const HexMesh& mesh, const Rig& rig);

/// Quadrilaterals on the outside of the mesh, corner node indices, oriented outwards.
[[nodiscard]] std::vector<std::array<int, 4>> surface_faces(const HexMesh& mesh);

/// A material point of a mesh: value = sum_i weights[i] field[nodes[i]].
struct MeshPoint {
  int element = -1;
  Eigen::Vector3d xi =
      Eigen::Vector3d::Zero();  ///< of the mesh's point nearest to it, in [-1, 1]³ [-]
  std::vector<int> nodes;
  Eigen::VectorXd weights;     ///< shape functions at xi, continued linearly beside the mesh
  Eigen::Matrix3Xd gradients;  ///< their derivatives by x at xi, (3 x nodes) [1/m]
  double distance_m = 0.0;     ///< from the mesh; 0 inside [m]
};

/// Finds where `position` lies; beside the mesh the field is continued from its nearest point x*,
///
///     value = u(x*) + grad u(x*) (position - x*),
///
/// so a marker that overhangs moves as if glued there, with the material's own turn and stretch.
/// @throws InputError if the mesh has no element or the position is not finite. O(elements).
[[nodiscard]] MeshPoint locate(const HexMesh& mesh, const Eigen::Vector3d& position);

/// Value at `point` of a nodal vector field stacked as (3 num_nodes).
[[nodiscard]] Eigen::Vector3d interpolate(const MeshPoint& point, const Eigen::VectorXd& field);
/// Its gradient, d field_i / d x_j.
[[nodiscard]] Eigen::Matrix3d interpolate_gradient(const MeshPoint& point,
                                                   const Eigen::VectorXd& field);

}  // namespace twang
