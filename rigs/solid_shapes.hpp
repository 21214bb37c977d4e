// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/surface_mesh.hpp"

#include <Eigen/Core>

namespace twang {

/// The prism over an outline, from y = `from` to y = `to`.
///
/// @param outline  corners (x, z) of a polygon that does not cross itself, anticlockwise with x to
/// the right and z up, (2 x corners) [m]
/// @throws InputError if the outline has under three corners, crosses itself or runs clockwise
[[nodiscard]] SurfaceMesh extrude(const Eigen::Matrix2Xd& outline, double from, double to);

/// The body a profile sweeps around the z axis, as a prism of `sides` around its foot.
///
/// @param profile  (radius, z) from the foot up, radii > 0, (2 x points) [m]; its ends are closed
/// by flat faces
[[nodiscard]] SurfaceMesh revolve(const Eigen::Matrix2Xd& profile, int sides);

/// A tube along a path with round cross-sections and flat ends.
///
/// @param path   no two neighbours equal, (3 x points) [m]
/// @param radii  > 0, one for each point [m]
[[nodiscard]] SurfaceMesh sweep(const Eigen::Matrix3Xd& path,
                                const Eigen::VectorXd& radii,
                                int sides);

/// A flat strip along a path, as a leaf: `widths` across the path and the vertical, `thickness`
/// across both, with flat ends. The path runs nowhere straight up.
[[nodiscard]] SurfaceMesh ribbon(const Eigen::Matrix3Xd& path,
                                 const Eigen::VectorXd& widths,
                                 double thickness);

/// Several surfaces as one.
[[nodiscard]] SurfaceMesh join(const std::vector<SurfaceMesh>& surfaces);

/// The surface moved by `by` [m].
[[nodiscard]] SurfaceMesh moved(SurfaceMesh surface, const Eigen::Vector3d& by);

}  // namespace twang
