// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <string_view>
#include <vector>

namespace twang {

/// hex8: trilinear, 2 x 2 x 2 Gauss points. hex20: serendipity, 3 x 3 x 3 Gauss points.
///
/// hex8e: the nodes, functions and points of hex8, and three internal modes that enhance its
/// deformation gradient [Simo & Rifai 1990; Simo & Armero 1992], so that it bends without shear,
///
///     F = 1 + grad u + sum_i alpha_i ⊗ g_i,   g_i = (j0 / j) J0^-T xi_i e_i
///
/// with J the Jacobian, j its determinant and 0 the element's middle; each element's alpha minimize
/// its energy. What lambda multiplies is summed over the middles of the six faces instead. That is
/// exact for volumes and mean gradients (the patch test) and for dilatations linear in xi, and does
/// not see bilinear ones: nu near 0.5 does not lock the element.
///
/// Under large strain alpha is found anew at every displacement. Where the strain has lost its
/// stability, and alpha no minimum, the energy is infinite, as of an element inside out: the
/// neo-Hookean model stands a compression to a tenth, Saint Venant-Kirchhoff material of nu 0.45
/// not one to 0.9 if it is held laterally.
enum class ElementKind { Hex8, Hex20, Hex8e };

[[nodiscard]] std::string_view to_string(ElementKind kind);
/// @throws InputError for any name but "hex8", "hex20" and "hex8e"
[[nodiscard]] ElementKind element_kind_from(std::string_view name);
[[nodiscard]] int nodes_per_element(ElementKind kind);

/// Where node `node` of the element stands in [-1, 1]³: corners first, then mid-edge nodes. The
/// order is VTK's (VTK_HEXAHEDRON, VTK_QUADRATIC_HEXAHEDRON), which is also that of C3D8 and C3D20
/// in CalculiX's input.
[[nodiscard]] Eigen::Vector3d reference_node(int node);

/// Values of the shape functions at `xi` in [-1, 1]³, (nodes).
[[nodiscard]] Eigen::VectorXd shape_functions(ElementKind kind, const Eigen::Vector3d& xi);
/// Their derivatives by xi, (3 x nodes).
[[nodiscard]] Eigen::Matrix3Xd shape_gradients(ElementKind kind, const Eigen::Vector3d& xi);

/// Internal modes of an element that are no nodes: 3 for hex8e, else 0.
[[nodiscard]] int num_internal_modes(ElementKind kind);

/// A quadrature rule on [-1, 1]³.
struct Quadrature {
  std::vector<Eigen::Vector3d> points;
  std::vector<double> weights;  ///< sum 8
};
/// The element's own rule: 8 points for hex8 and hex8e, 27 for hex20.
[[nodiscard]] const Quadrature& quadrature(ElementKind kind);

}  // namespace twang
