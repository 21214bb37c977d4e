// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang::test {

inline Eigen::Vector3d mm(double x, double y, double z) { return Eigen::Vector3d(x, y, z) * 1e-3; }

/// A rig of boxes of one material without a stated modulus.
inline Rig rig_of_boxes(const std::vector<Box>& boxes,
                        const Box& clamp,
                        double poissons_ratio,
                        double density_kg_m3) {
  Rig rig;
  rig.name = "boxes";
  RigMaterial material;
  material.name = "part";
  material.poissons_ratio = poissons_ratio;
  material.density_kg_m3 = density_kg_m3;
  rig.materials = {material};
  for (const Box& box : boxes) rig.parts.push_back({"part", box});
  rig.clamps = {clamp};
  return rig;
}

/// A beam along x, clamped at x = 0 [m].
inline Rig beam(const Eigen::Vector3d& size, double poissons_ratio, double density_kg_m3) {
  return rig_of_boxes({{Eigen::Vector3d::Zero(), size}},
                      {Eigen::Vector3d::Zero(), Eigen::Vector3d(0.0, size.y(), size.z())},
                      poissons_ratio,
                      density_kg_m3);
}

inline Rig short_beam() { return beam(mm(40, 10, 5), 0.3, 1000.0); }

/// Bounds that end a ladder within a second.
inline LadderOptions small_ladder() {
  LadderOptions options;
  options.max_dofs = 4000;
  options.num_frequencies = 6;
  return options;
}

/// The L-shaped calibration rig: plate, leg one cell thick at 1.5 mm, arm; 24 mm deep.
inline Rig l_rig() {
  return rig_of_boxes({{mm(0, 0, 0), mm(60, 24, 3)},
                       {mm(45, 0, 3), mm(46.5, 24, 19.5)},
                       {mm(7.5, 0, 19.5), mm(46.5, 24, 27)}},
                      {mm(0, 0, 0), mm(60, 24, 0)},
                      0.45,
                      1205.0);
}

}  // namespace twang::test
