// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/rig.hpp"

#include "core/error.hpp"
#include "rigs/surface_mesh.hpp"

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

Box box_around(const Box& box) { return box; }

Box box_around(const Cylinder& cylinder) {
  const Eigen::Vector3d axis = (cylinder.to - cylinder.from).normalized();
  const Eigen::Vector3d reach =
      cylinder.radius * (1.0 - axis.array().square()).max(0.0).sqrt().matrix();
  return {cylinder.from.cwiseMin(cylinder.to) - reach, cylinder.from.cwiseMax(cylinder.to) + reach};
}

Box box_around(const SurfaceFile& surface) {
  return surface.box ? *surface.box : bounds_of(read_surface(surface));
}

bool inside(const Box& box, const Eigen::Vector3d& point) {
  return (point.array() >= box.min.array()).all() && (point.array() < box.max.array()).all();
}

bool inside(const Cylinder& cylinder, const Eigen::Vector3d& point) {
  const Eigen::Vector3d axis = cylinder.to - cylinder.from;
  const double along = (point - cylinder.from).dot(axis) / axis.squaredNorm();
  const Eigen::Vector3d across = point - cylinder.from - along * axis;
  return along >= 0.0 && along < 1.0 && across.norm() <= cylinder.radius;
}

bool inside(const SurfaceFile& surface, const Eigen::Vector3d& /*point*/) {
  throw InputError(surface.file.string() +
                   ": is a surface, whether a point lies in it must be asked of its triangles");
}

}  // namespace

bool Box::contains(const Eigen::Vector3d& point, double margin) const {
  return (point.array() >= min.array() - margin).all() &&
         (point.array() <= max.array() + margin).all();
}

double Box::distance(const Eigen::Vector3d& point) const {
  return (point - point.cwiseMax(min).cwiseMin(max)).norm();
}

std::string_view to_string(MarkerKind kind) {
  switch (kind) {
    case MarkerKind::Cross:
      return "cross";
    case MarkerKind::Dot:
      return "dot";
    case MarkerKind::Ring:
      return "ring";
    case MarkerKind::Checker:
      return "checker";
    case MarkerKind::ArUco:
      return "aruco";
    case MarkerKind::AprilTag:
      return "apriltag";
    case MarkerKind::Patch:
      return "patch";
  }
  throw InputError("marker kind is not one of the seven kinds");
}

std::string_view to_string(PartialCells partial_cells) {
  switch (partial_cells) {
    case PartialCells::None:
      return "none";
    case PartialCells::Mass:
      return "mass";
    case PartialCells::MassAndStiffness:
      return "mass_and_stiffness";
  }
  throw InputError("the rule for partial cells is none of the three");
}

PartialCells partial_cells_from(std::string_view name) {
  for (const PartialCells rule :
       {PartialCells::None, PartialCells::Mass, PartialCells::MassAndStiffness}) {
    if (name == to_string(rule)) return rule;
  }
  throw InputError("partial cells are \"" + std::string(name) +
                   "\", must be none, mass or mass_and_stiffness");
}

const Marker* Rig::find_marker(std::string_view id) const {
  const auto it = std::find_if(
      markers.begin(), markers.end(), [&](const Marker& marker) { return marker.id == id; });
  return it == markers.end() ? nullptr : &*it;
}

const RigMaterial* Rig::find_material(std::string_view material_name) const {
  const auto it = std::find_if(materials.begin(), materials.end(), [&](const RigMaterial& m) {
    return m.name == material_name;
  });
  return it == materials.end() ? nullptr : &*it;
}

Box Rig::bounding_box() const {
  if (parts.empty()) {
    throw InputError((file.empty() ? name : file.string()) +
                     ": has no [[part]], must have one to have a size");
  }
  const auto box_of = [](const PartSolid& solid) {
    return std::visit([](const auto& shape) { return box_around(shape); }, solid.shape);
  };
  Box all = box_of(parts.front());
  for (const PartSolid& solid : parts) {
    const Box box = box_of(solid);
    all.min = all.min.cwiseMin(box.min);
    all.max = all.max.cwiseMax(box.max);
  }
  return all;
}

bool contains(const PartSolid& solid, const Eigen::Vector3d& point) {
  return std::visit([&](const auto& shape) { return inside(shape, point); }, solid.shape);
}

}  // namespace twang
