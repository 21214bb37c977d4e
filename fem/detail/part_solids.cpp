// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/part_solids.hpp"

#include <fmt/format.h>

namespace twang {

std::vector<SolidGeometry> read_solids(const Rig& rig) {
  std::vector<SolidGeometry> solids;
  for (const PartSolid& solid : rig.parts) {
    SolidGeometry geometry;
    geometry.solid = solid;
    if (const auto* file = std::get_if<SurfaceFile>(&solid.shape)) {
      geometry.surface = read_closed_surface(*file);
      geometry.bounds = bounds_of(geometry.surface->mesh);
    } else {
      Rig alone;
      alone.parts.push_back(solid);
      geometry.bounds = alone.bounding_box();
    }
    solids.push_back(std::move(geometry));
  }
  return solids;
}

Box bounds_of(const std::vector<SolidGeometry>& solids) {
  Box all = solids.front().bounds;
  for (const SolidGeometry& solid : solids) {
    all.min = all.min.cwiseMin(solid.bounds.min);
    all.max = all.max.cwiseMax(solid.bounds.max);
  }
  return all;
}

std::string describe_solid(const Rig& rig, int solid) {
  const PartSolid& at = rig.parts[static_cast<std::size_t>(solid)];
  const auto* surface = std::get_if<SurfaceFile>(&at.shape);
  const std::string shape = surface != nullptr ? surface->file.filename().string()
                            : std::holds_alternative<Box>(at.shape) ? std::string("box")
                                                                    : std::string("cylinder");
  return fmt::format("{}: part {} of {} ({}, material \"{}\")",
                     rig.file.empty() ? rig.name : rig.file.string(),
                     solid + 1,
                     rig.parts.size(),
                     shape,
                     at.material);
}

}  // namespace twang
