// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/read_mesh.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "fem/detail/raw_mesh.hpp"
#include "fem/hex_edges.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

namespace twang {
namespace {

/// Numbers the nodes that elements have, in their order, and leaves out the others.
void drop_unused_nodes(HexMesh& mesh) {
  std::vector<int> number(static_cast<std::size_t>(mesh.num_nodes()), -1);
  for (const int n : mesh.elements.reshaped()) number[static_cast<std::size_t>(n)] = 0;
  int count = 0;
  for (std::size_t n = 0; n < number.size(); ++n) {
    if (number[n] < 0) continue;
    number[n] = count;
    mesh.nodes.col(count++) = mesh.nodes.col(static_cast<Eigen::Index>(n));
  }
  mesh.nodes.conservativeResize(3, count);
  for (int& n : mesh.elements.reshaped()) n = number[static_cast<std::size_t>(n)];
}

/// An element that shares no node, by way of others, with the first; -1 if there is none.
int find_loose_element(const HexMesh& mesh) {
  std::vector<int> parent(static_cast<std::size_t>(mesh.num_nodes()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int n) {
    while (parent[static_cast<std::size_t>(n)] != n) {
      int& up = parent[static_cast<std::size_t>(n)];
      up = parent[static_cast<std::size_t>(up)];
      n = up;
    }
    return n;
  };
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (int a = 1; a < mesh.elements.rows(); ++a) {
      parent[static_cast<std::size_t>(root(mesh.elements(a, e)))] = root(mesh.elements(0, e));
    }
  }
  for (int e = 0; e < mesh.num_elements(); ++e) {
    if (root(mesh.elements(0, e)) != root(mesh.elements(0, 0))) return e;
  }
  return -1;
}

/// Determinant of the map from the reference element at its middle.
double orientation(const HexMesh& mesh, int element) {
  const Eigen::Matrix3Xd dN = shape_gradients(mesh.kind, Eigen::Vector3d::Zero());
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
  for (int a = 0; a < dN.cols(); ++a) {
    jacobian += mesh.nodes.col(mesh.elements(a, element)) * dN.col(a).transpose();
  }
  return jacobian.determinant();
}

void check(const HexMesh& mesh, const std::string& file) {
  for (int e = 0; e < mesh.num_elements(); ++e) {
    if (orientation(mesh, e) > 0.0) continue;
    throw InputError(
        fmt::format("{}: hexahedron {} of {} is flat or turned inside out, its nodes must "
                    "be in the order of the format",
                    file,
                    e + 1,
                    mesh.num_elements()));
  }
  const int loose = find_loose_element(mesh);
  if (loose >= 0) {
    throw InputError(
        fmt::format("{}: hexahedron {} of {} shares no node with the first one's piece, "
                    "the elements must hang together",
                    file,
                    loose + 1,
                    mesh.num_elements()));
  }
}

std::string in_quotes(const std::vector<std::string>& names) {
  std::vector<std::string> quoted;
  for (const std::string& name : names) quoted.push_back("\"" + name + "\"");
  return fmt::format("{}", fmt::join(quoted, ", "));
}

}  // namespace

std::string RawMesh::add(ElementKind element, std::vector<int> its_nodes, std::string group) {
  if (kind && *kind != element)
    return "holds elements of 8 and of 20 nodes, must be all of one kind";
  kind = element;
  elements.push_back(std::move(its_nodes));
  groups.push_back(std::move(group));
  return {};
}

HexMesh read_mesh(const MeshFile& file) {
  const std::string name = file.file.string();
  const std::string content = read_file(file.file);
  const RawMesh raw =
      file.file.extension() == ".msh" ? parse_msh(name, content) : parse_vtu(name, content);
  if (raw.elements.empty()) {
    throw InputError(fmt::format("{}: has no hexahedron, must be a mesh of them", name));
  }
  HexMesh mesh;
  mesh.kind = *raw.kind;
  mesh.nodes.resize(3, static_cast<Eigen::Index>(raw.nodes.size()));
  for (std::size_t n = 0; n < raw.nodes.size(); ++n) {
    mesh.nodes.col(static_cast<Eigen::Index>(n)) = file.metres_per_unit * raw.nodes[n] + file.at;
  }
  mesh.elements.resize(nodes_per_element(mesh.kind),
                       static_cast<Eigen::Index>(raw.elements.size()));
  mesh.material_names = raw.groups;
  std::sort(mesh.material_names.begin(), mesh.material_names.end());
  mesh.material_names.erase(std::unique(mesh.material_names.begin(), mesh.material_names.end()),
                            mesh.material_names.end());
  for (std::size_t e = 0; e < raw.elements.size(); ++e) {
    for (std::size_t a = 0; a < raw.elements[e].size(); ++a) {
      mesh.elements(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(e)) =
          raw.elements[e][a];
    }
    const auto group =
        std::lower_bound(mesh.material_names.begin(), mesh.material_names.end(), raw.groups[e]);
    mesh.material_of_element.push_back(static_cast<int>(group - mesh.material_names.begin()));
  }
  drop_unused_nodes(mesh);
  check(mesh, name);
  mesh.part_volume_m3 = mesh.volume();
  mesh.requested_dx_m = std::cbrt(mesh.part_volume_m3 / mesh.num_elements());
  return mesh;
}

HexMesh with_kind(const HexMesh& mesh, ElementKind kind) {
  if (mesh.kind == kind) return mesh;
  HexMesh other = mesh;
  other.kind = kind;
  if (nodes_per_element(kind) == mesh.elements.rows()) return other;
  if (kind != ElementKind::Hex20) {
    other.elements = mesh.elements.topRows(8).eval();
    drop_unused_nodes(other);
    return other;
  }
  std::map<std::array<int, 2>, int> middle;
  std::vector<Eigen::Vector3d> added;
  other.elements.resize(nodes_per_element(kind), mesh.elements.cols());
  other.elements.topRows(8) = mesh.elements;
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (std::size_t i = 0; i < kHexEdges.size(); ++i) {
      const int a = mesh.elements(kHexEdges[i][0], e);
      const int b = mesh.elements(kHexEdges[i][1], e);
      const auto [at, is_new] = middle.try_emplace(
          {std::min(a, b), std::max(a, b)}, mesh.num_nodes() + static_cast<int>(added.size()));
      if (is_new) added.push_back(0.5 * (mesh.nodes.col(a) + mesh.nodes.col(b)));
      other.elements(8 + static_cast<Eigen::Index>(i), e) = at->second;
    }
  }
  other.nodes.conservativeResize(3, mesh.num_nodes() + static_cast<Eigen::Index>(added.size()));
  for (std::size_t i = 0; i < added.size(); ++i) {
    other.nodes.col(mesh.num_nodes() + static_cast<Eigen::Index>(i)) = added[i];
  }
  return other;
}

HexMesh read_mesh_of(const Rig& rig, ElementKind kind) {
  const MeshFile& file = *rig.meshing.file;
  HexMesh mesh = with_kind(read_mesh(file), kind);
  for (const auto& [group, material] : file.material_of_group) {
    if (std::find(mesh.material_names.begin(), mesh.material_names.end(), group) !=
        mesh.material_names.end()) {
      continue;
    }
    throw InputError(fmt::format("{}: the mesh has no group \"{}\", it has {}",
                                 file.file.string(),
                                 group,
                                 in_quotes(mesh.material_names)));
  }
  std::vector<std::string> names;
  std::vector<int> number;
  for (const std::string& group : mesh.material_names) {
    const auto given = file.material_of_group.find(group);
    std::string material = given != file.material_of_group.end() ? given->second : group;
    if (rig.find_material(material) == nullptr) {
      if (rig.materials.size() != 1 || !file.material_of_group.empty()) {
        throw InputError(
            fmt::format("{}: the group \"{}\" has no material; name it in [mesh] groups, "
                        "as groups = {{ \"{}\" = \"NAME\" }}",
                        file.file.string(),
                        group,
                        group));
      }
      material = rig.materials.front().name;
    }
    const auto at = std::find(names.begin(), names.end(), material);
    number.push_back(static_cast<int>(at - names.begin()));
    if (at == names.end()) names.push_back(material);
  }
  for (int& material : mesh.material_of_element)
    material = number[static_cast<std::size_t>(material)];
  mesh.material_names = names;
  return mesh;
}

}  // namespace twang
