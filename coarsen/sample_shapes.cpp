// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/sample_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace twang {
namespace {

using Eigen::Vector3d;
using CellIndex = std::array<long, 3>;

/// Finds the elements around a point by their cells.
class CellIndexOfElements {
 public:
  explicit CellIndexOfElements(const HexMesh& mesh)
      : m_mesh(mesh), m_origin(mesh.nodes.rowwise().minCoeff()) {
    for (int e = 0; e < mesh.num_elements(); ++e) {
      m_element_of_cell[cell_of(
          0.5 * (mesh.nodes.col(mesh.elements(0, e)) + mesh.nodes.col(mesh.elements(6, e))))] = e;
    }
  }

  /// Those in the point's own cell and its 26 neighbours.
  [[nodiscard]] std::vector<int> around(const Vector3d& point) const {
    const CellIndex centre = cell_of(point);
    std::vector<int> elements;
    for (long i = -1; i <= 1; ++i) {
      for (long j = -1; j <= 1; ++j) {
        for (long k = -1; k <= 1; ++k) {
          const auto found = m_element_of_cell.find({centre[0] + i, centre[1] + j, centre[2] + k});
          if (found != m_element_of_cell.end()) elements.push_back(found->second);
        }
      }
    }
    std::sort(elements.begin(), elements.end());
    return elements;
  }

 private:
  [[nodiscard]] CellIndex cell_of(const Vector3d& point) const {
    CellIndex cell{};
    for (int k = 0; k < 3; ++k) {
      cell[static_cast<std::size_t>(k)] =
          std::lround(std::floor((point(k) - m_origin(k)) / m_mesh.actual_dx_m(k)));
    }
    return cell;
  }

  const HexMesh& m_mesh;
  Vector3d m_origin;
  std::map<CellIndex, int> m_element_of_cell;
};

/// A mesh of some elements of another, and the other's number of each node.
struct Excerpt {
  HexMesh mesh;
  std::vector<int> nodes;
};

Excerpt excerpt(const HexMesh& mesh, const std::vector<int>& elements) {
  Excerpt part;
  part.mesh.kind = mesh.kind;
  part.mesh.elements.resize(mesh.elements.rows(), static_cast<Eigen::Index>(elements.size()));
  for (const int e : elements) {
    for (Eigen::Index a = 0; a < mesh.elements.rows(); ++a) {
      part.nodes.push_back(mesh.elements(a, e));
    }
  }
  std::sort(part.nodes.begin(), part.nodes.end());
  part.nodes.erase(std::unique(part.nodes.begin(), part.nodes.end()), part.nodes.end());
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (Eigen::Index a = 0; a < mesh.elements.rows(); ++a) {
      const auto found =
          std::lower_bound(part.nodes.begin(), part.nodes.end(), mesh.elements(a, elements[i]));
      part.mesh.elements(a, static_cast<Eigen::Index>(i)) =
          static_cast<int>(found - part.nodes.begin());
    }
  }
  part.mesh.nodes.resize(3, static_cast<Eigen::Index>(part.nodes.size()));
  for (std::size_t n = 0; n < part.nodes.size(); ++n) {
    part.mesh.nodes.col(static_cast<Eigen::Index>(n)) = mesh.nodes.col(part.nodes[n]);
  }
  return part;
}

/// `locate` among the elements around the point; in the whole mesh where a farther element could be
/// the nearest.
MeshPoint locate_nearby(const HexMesh& mesh,
                        const CellIndexOfElements& index,
                        const Vector3d& position) {
  const std::vector<int> nearby = index.around(position);
  if (nearby.empty()) return locate(mesh, position);
  const Excerpt part = excerpt(mesh, nearby);
  MeshPoint point = locate(part.mesh, position);
  if (point.distance_m > mesh.actual_dx_m.minCoeff()) return locate(mesh, position);
  point.element = nearby[static_cast<std::size_t>(point.element)];
  for (int& node : point.nodes) node = part.nodes[static_cast<std::size_t>(node)];
  return point;
}

}  // namespace

Eigen::MatrixXd sample_fields(const HexMesh& mesh,
                              const Eigen::MatrixXd& fields,
                              const Eigen::Matrix3Xd& points) {
  const CellIndexOfElements index(mesh);
  Eigen::MatrixXd samples(3 * points.cols(), fields.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const MeshPoint point = locate_nearby(mesh, index, points.col(i));
    auto sample = samples.middleRows(3 * i, 3);
    sample.setZero();
    for (std::size_t n = 0; n < point.nodes.size(); ++n) {
      sample +=
          point.weights(static_cast<Eigen::Index>(n)) * fields.middleRows(3 * point.nodes[n], 3);
    }
  }
  return samples;
}

}  // namespace twang
