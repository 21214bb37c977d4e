// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/part_solids.hpp"

#include "fem/detail/surface_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

/// Lines across the longer side of a surface along which it is looked at for crossings.
constexpr int kLines = 200;

std::vector<double> middles(double low, double high, double step) {
  const auto count = static_cast<int>(std::max(1.0, std::ceil((high - low) / step)));
  std::vector<double> places;
  for (int i = 0; i < count; ++i) places.push_back(low + (i + 0.5) / count * (high - low));
  return places;
}

/// Notes what lies inside twice, or inside a piece that is turned inside out.
void find_crossings(SolidGeometry& geometry, const std::string& file) {
  const Eigen::Vector3d size = geometry.bounds.max - geometry.bounds.min;
  const double step = std::max(size.x(), size.y()) / kLines;
  const auto x = middles(geometry.bounds.min.x(), geometry.bounds.max.x(), step);
  const auto y = middles(geometry.bounds.min.y(), geometry.bounds.max.y(), step);
  const SurfaceColumns columns(geometry.surface->mesh, x, y);
  double twice = 0.0;
  double wrong_way = 0.0;
  for (std::size_t j = 0; j < y.size(); ++j) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      int winding = 0;
      double z = 0.0;
      for (const SurfaceColumns::Crossing& crossing : columns.at(i, j)) {
        if (winding > 1) twice += crossing.z - z;
        if (winding < 0) wrong_way += crossing.z - z;
        winding += crossing.turn;
        z = crossing.z;
      }
    }
  }
  constexpr double kNotable = 1e-6;  // of the volume; less is rounding where shells touch
  constexpr double kCubicMillimetres = 1e9;
  const auto say = [&](double length, const char* what) {
    const double volume = length * size.x() * size.y() / static_cast<double>(x.size() * y.size());
    if (volume <= kNotable * geometry.surface->volume_m3) return;
    geometry.crosses_itself = true;
    geometry.surface->notes.push_back(
        fmt::format("{}: crosses itself or has shells that overlap: {:.3g} mm³ lie {}",
                    file,
                    volume * kCubicMillimetres,
                    what));
  };
  say(twice, "inside more than once and count once");
  say(wrong_way, "inside a piece turned inside out and count as empty");
}

}  // namespace

std::vector<SolidGeometry> read_solids(const Rig& rig) {
  std::vector<SolidGeometry> solids;
  for (const PartSolid& solid : rig.parts) {
    SolidGeometry geometry;
    geometry.solid = solid;
    if (const auto* file = std::get_if<SurfaceFile>(&solid.shape)) {
      geometry.surface = read_closed_surface(*file);
      geometry.bounds = bounds_of(geometry.surface->mesh);
      find_crossings(geometry, file->file.string());
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
