// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/thinnest_wall.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "fem/detail/surface_columns.hpp"
#include "rigs/closed_surface.hpp"

#include <algorithm>

namespace twang {
namespace {

/// Lines across the longer side of a surface, and the share of pieces that may be shorter [-].
constexpr int kLines = 200;
constexpr double kShorter = 0.02;

/// Evenly spread places from `low` to `high`, none of them at an end or a simple fraction.
std::vector<double> spread(double low, double high, double step) {
  const double count = std::max(1.0, std::ceil((high - low) / step));
  std::vector<double> places;
  constexpr double kOffset = 0.4837;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    places.push_back(low + (i + kOffset) / count * (high - low));
  }
  return places;
}

/// What 98 of a hundred pieces of lines along z reach.
double short_piece(const SurfaceMesh& surface) {
  const Box box = bounds_of(surface);
  const double step = (box.max - box.min).maxCoeff() / kLines;
  const std::vector<double> x = spread(box.min.x(), box.max.x(), step);
  const std::vector<double> y = spread(box.min.y(), box.max.y(), step);
  const SurfaceColumns columns(surface, x, y);
  std::vector<double> pieces;
  for (std::size_t j = 0; j < y.size(); ++j) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      int winding = 0;
      double entered = 0.0;
      for (const SurfaceColumns::Crossing& crossing : columns.at(i, j)) {
        const bool was_inside = winding > 0;
        winding += crossing.turn;
        if (!was_inside && winding > 0) entered = crossing.z;
        if (was_inside && winding <= 0) pieces.push_back(crossing.z - entered);
      }
    }
  }
  if (pieces.empty()) return kInfinity;
  const auto at =
      pieces.begin() + static_cast<std::ptrdiff_t>(kShorter * static_cast<double>(pieces.size()));
  std::nth_element(pieces.begin(), at, pieces.end());
  return *at;
}

double thinnest(const SurfaceFile& file) {
  SurfaceMesh surface = read_closed_surface(file).mesh;
  double least = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    least = std::min(least, short_piece(surface));
    // x, y, z become y, z, x, which keeps the surface facing outwards
    const Eigen::Matrix3Xd turned = surface.vertices;
    for (int i = 0; i < 3; ++i) surface.vertices.row(i) = turned.row((i + 1) % 3);
  }
  return least;
}

double thinnest(const Box& box) { return (box.max - box.min).minCoeff(); }

double thinnest(const Cylinder& cylinder) {
  return std::min(2.0 * cylinder.radius, (cylinder.to - cylinder.from).norm());
}

}  // namespace

double thinnest_wall_m(const Rig& rig) {
  if (rig.parts.empty()) {
    throw InputError((rig.file.empty() ? rig.name : rig.file.string()) +
                     ": has no [[part]], must have one to have a thickness");
  }
  double least = kInfinity;
  for (const PartSolid& solid : rig.parts) {
    least =
        std::min(least, std::visit([](const auto& shape) { return thinnest(shape); }, solid.shape));
  }
  return least;
}

}  // namespace twang
