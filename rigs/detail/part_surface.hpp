// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

#include <vector>

namespace twang::detail {

/// Distance from `point` to the nearest point of the union of `solids`, boxes and cylinders only; 0
/// inside [m].
[[nodiscard]] double distance_to_part(const std::vector<PartSolid>& solids,
                                      const Eigen::Vector3d& point);

/// Whether `point`, inside the union of `solids`, lies no deeper than `reach` under its surface
/// [m].
///
/// Asked of points spread over the sphere of radius `reach` around it, along the axes and the
/// diagonals among them: is one of them outside? Faces that two solids share are thereby no
/// surface.
[[nodiscard]] bool reaches_surface(const std::vector<PartSolid>& solids,
                                   const Eigen::Vector3d& point,
                                   double reach);

}  // namespace twang::detail
