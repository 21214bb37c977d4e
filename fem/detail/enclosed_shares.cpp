// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/enclosed_shares.hpp"

#include "core/constants.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace twang {
namespace {

/// Shares this near 0 or 1 are that, but for round-off [-].
constexpr double kRounding = 1e-9;

/// A triangle cut by six planes has at most nine corners.
struct Polygon {
  Eigen::Matrix<double, 3, 10> corners = Eigen::Matrix<double, 3, 10>::Zero();
  int size = 0;
  void add(const Eigen::Vector3d& x) {
    assert(size < corners.cols());
    corners.col(size++) = x;
  }
};

/// Cuts a convex polygon at the plane x[axis] = place.
void cut(const Polygon& whole, int axis, double place, Polygon& below, Polygon& above) {
  below.size = 0;
  above.size = 0;
  for (int i = 0; i < whole.size; ++i) {
    const Eigen::Vector3d a = whole.corners.col(i);
    const Eigen::Vector3d b = whole.corners.col((i + 1) % whole.size);
    if (a[axis] <= place) below.add(a);
    if (a[axis] >= place) above.add(a);
    if ((a[axis] < place && b[axis] > place) || (a[axis] > place && b[axis] < place)) {
      Eigen::Vector3d x = a + (place - a[axis]) / (b[axis] - a[axis]) * (b - a);
      x[axis] = place;
      below.add(x);
      above.add(x);
    }
  }
}

/// Adds up, in units of cells.
class Shares {
 public:
  explicit Shares(const std::array<int, 3>& count)
      : m_count(count),
        m_share(static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) *
                    static_cast<std::size_t>(count[2]),
                0.0),
        m_cover(m_share.size(), 0.0) {}

  void add(const Polygon& polygon, int axis = 0) {
    if (polygon.size < 3) return;
    if (axis == 3) {
      add_piece(polygon);
      return;
    }
    const double low = polygon.corners.row(axis).head(polygon.size).minCoeff();
    const double high = polygon.corners.row(axis).head(polygon.size).maxCoeff();
    const auto at = static_cast<std::size_t>(axis);
    const double last_cell = m_count[at] - 1;
    const int first = static_cast<int>(std::clamp(std::floor(low), 0.0, last_cell));
    const int last =
        std::max(first, static_cast<int>(std::clamp(std::ceil(high) - 1.0, 0.0, last_cell)));
    if (first == last) {
      m_cell[at] = first;
      add(polygon, axis + 1);
      return;
    }
    Polygon rest = polygon;
    Polygon below;
    Polygon above;
    for (m_cell[at] = first; m_cell[at] < last; ++m_cell[at]) {
      cut(rest, axis, m_cell[at] + 1.0, below, above);
      add(below, axis + 1);
      rest = above;
    }
    add(rest, axis + 1);
  }

  [[nodiscard]] std::vector<double> sum_columns() {
    const auto layer = static_cast<std::size_t>(m_count[0]) * static_cast<std::size_t>(m_count[1]);
    for (std::size_t column = 0; column < layer; ++column) {
      double covered = 0.0;
      for (std::size_t at = m_share.size() - layer + column;; at -= layer) {
        const double share = m_share[at] + covered;
        m_share[at] = share < kRounding ? 0.0 : share > 1.0 - kRounding ? 1.0 : share;
        covered += m_cover[at];
        if (at < layer) break;
      }
    }
    return std::move(m_share);
  }

 private:
  void add_piece(const Polygon& piece) {
    const std::size_t cell =
        static_cast<std::size_t>(m_cell[0]) +
        static_cast<std::size_t>(m_count[0]) *
            (static_cast<std::size_t>(m_cell[1]) +
             static_cast<std::size_t>(m_count[1]) * static_cast<std::size_t>(m_cell[2]));
    const Eigen::Vector3d apex = piece.corners.col(0);
    for (int i = 1; i + 1 < piece.size; ++i) {
      const Eigen::Vector3d b = piece.corners.col(i) - apex;
      const Eigen::Vector3d c = piece.corners.col(i + 1) - apex;
      const double area = 0.5 * (b.x() * c.y() - b.y() * c.x());
      m_cover[cell] += area;
      m_share[cell] += area * (apex.z() + (b.z() + c.z()) / 3.0 - m_cell[2]);
    }
  }

  std::array<int, 3> m_count;
  std::array<int, 3> m_cell = {0, 0, 0};
  std::vector<double> m_share;
  std::vector<double> m_cover;  ///< area of the pieces in a cell seen from above
};

}  // namespace

std::vector<double> enclosed_shares(const CellBlock& block, const SurfaceMesh& surface) {
  Shares shares(block.count);
  Polygon triangle;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    triangle.size = 0;
    for (const int v : surface.triangles.col(t)) {
      triangle.add((surface.vertices.col(v) - block.origin).cwiseQuotient(block.cell));
    }
    const Eigen::Vector3d b = triangle.corners.col(1) - triangle.corners.col(0);
    const Eigen::Vector3d c = triangle.corners.col(2) - triangle.corners.col(0);
    if (b.x() * c.y() == b.y() * c.x()) continue;  // seen edge-on it covers nothing
    shares.add(triangle);
  }
  return shares.sum_columns();
}

SurfaceMesh surface_of(const Cylinder& cylinder) {
  constexpr int kSides = 512;
  constexpr double kStep = 2.0 * kPi / kSides;
  // The area of the polygon is that of the circle.
  const double radius = cylinder.radius * std::sqrt(kStep / std::sin(kStep));
  const Eigen::Vector3d axis = (cylinder.to - cylinder.from).normalized();
  const Eigen::Vector3d right = axis.unitOrthogonal();
  const Eigen::Vector3d ahead = axis.cross(right);
  SurfaceMesh mesh;
  mesh.vertices.resize(3, 2 * kSides + 2);
  mesh.triangles.resize(3, 4 * kSides);
  const int bottom = 2 * kSides;
  const int top = bottom + 1;
  mesh.vertices.col(bottom) = cylinder.from;
  mesh.vertices.col(top) = cylinder.to;
  for (int s = 0; s < kSides; ++s) {
    const Eigen::Vector3d out =
        radius * (std::cos(s * kStep) * right + std::sin(s * kStep) * ahead);
    mesh.vertices.col(2 * s) = cylinder.from + out;
    mesh.vertices.col(2 * s + 1) = cylinder.to + out;
    const int low = 2 * s;
    const int next = 2 * ((s + 1) % kSides);
    mesh.triangles.col(4 * s) = Eigen::Vector3i(low, next, next + 1);
    mesh.triangles.col(4 * s + 1) = Eigen::Vector3i(low, next + 1, low + 1);
    mesh.triangles.col(4 * s + 2) = Eigen::Vector3i(bottom, next, low);
    mesh.triangles.col(4 * s + 3) = Eigen::Vector3i(top, low + 1, next + 1);
  }
  return mesh;
}

}  // namespace twang
