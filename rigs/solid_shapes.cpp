// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/solid_shapes.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <Eigen/Geometry>

#include <numeric>
#include <vector>

namespace twang {
namespace {

using Corner = Eigen::Vector2d;

double twice_area(const Corner& a, const Corner& b, const Corner& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Whether the corner `at` of the polygon `rest` can be cut off without touching another corner.
bool is_ear(const Eigen::Matrix2Xd& outline, const std::vector<int>& rest, std::size_t at) {
  const std::size_t n = rest.size();
  const Corner a = outline.col(rest[(at + n - 1) % n]);
  const Corner b = outline.col(rest[at]);
  const Corner c = outline.col(rest[(at + 1) % n]);
  if (twice_area(a, b, c) <= 0.0) return false;
  for (std::size_t i = 2; i + 1 < n; ++i) {
    const Corner p = outline.col(rest[(at + i) % n]);
    if (twice_area(a, b, p) >= 0.0 && twice_area(b, c, p) >= 0.0 && twice_area(c, a, p) >= 0.0) {
      return false;
    }
  }
  return true;
}

/// Triangles of a simple polygon, by cutting off ears [Meisters 1975]. O(n³)
std::vector<Eigen::Vector3i> triangulate(const Eigen::Matrix2Xd& outline) {
  if (outline.cols() < 3) throw InputError("an outline must have three corners or more");
  std::vector<int> rest(static_cast<std::size_t>(outline.cols()));
  std::iota(rest.begin(), rest.end(), 0);
  std::vector<Eigen::Vector3i> triangles;
  while (rest.size() > 3) {
    std::size_t at = 0;
    while (at < rest.size() && !is_ear(outline, rest, at)) ++at;
    if (at == rest.size()) {
      throw InputError(
          "an outline crosses itself or runs clockwise, must be simple and the other "
          "way round");
    }
    const std::size_t n = rest.size();
    triangles.emplace_back(rest[(at + n - 1) % n], rest[at], rest[(at + 1) % n]);
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(at));
  }
  triangles.emplace_back(rest[0], rest[1], rest[2]);
  return triangles;
}

/// Rings of equally many points one above the other, the first and last closed by `cap`, triangles
/// of a ring anticlockwise seen from beyond the last ring.
SurfaceMesh close_rings(const std::vector<Eigen::Matrix3Xd>& rings,
                        const std::vector<Eigen::Vector3i>& cap) {
  const auto sides = static_cast<int>(rings.front().cols());
  const auto levels = static_cast<int>(rings.size());
  SurfaceMesh mesh;
  mesh.vertices.resize(3, sides * levels);
  for (int level = 0; level < levels; ++level) {
    mesh.vertices.middleCols(level * sides, sides) = rings[static_cast<std::size_t>(level)];
  }
  std::vector<Eigen::Vector3i> triangles;
  for (int level = 0; level + 1 < levels; ++level) {
    for (int s = 0; s < sides; ++s) {
      const int a = level * sides + s;
      const int b = level * sides + (s + 1) % sides;
      triangles.emplace_back(a, b, b + sides);
      triangles.emplace_back(a, b + sides, a + sides);
    }
  }
  const int last = (levels - 1) * sides;
  for (const Eigen::Vector3i& t : cap) {
    triangles.emplace_back(t[0], t[2], t[1]);
    triangles.emplace_back(last + t[0], last + t[1], last + t[2]);
  }
  mesh.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    mesh.triangles.col(static_cast<Eigen::Index>(t)) = triangles[t];
  }
  return mesh;
}

/// A convex polygon's triangles around its first corner.
std::vector<Eigen::Vector3i> fan(int sides) {
  std::vector<Eigen::Vector3i> triangles;
  for (int s = 1; s + 1 < sides; ++s) triangles.emplace_back(0, s, s + 1);
  return triangles;
}

/// Direction of a path at one of its points.
Eigen::Vector3d tangent(const Eigen::Matrix3Xd& path, Eigen::Index at) {
  const Eigen::Index before = std::max<Eigen::Index>(at - 1, 0);
  const Eigen::Index after = std::min(at + 1, path.cols() - 1);
  return (path.col(after) - path.col(before)).normalized();
}

Eigen::Matrix3Xd circle(const Eigen::Vector3d& centre,
                        const Eigen::Vector3d& right,
                        const Eigen::Vector3d& ahead,
                        double radius,
                        int sides) {
  Eigen::Matrix3Xd ring(3, sides);
  for (int s = 0; s < sides; ++s) {
    const double angle = 2.0 * kPi * s / sides;
    ring.col(s) = centre + radius * (std::cos(angle) * right + std::sin(angle) * ahead);
  }
  return ring;
}

}  // namespace

SurfaceMesh extrude(const Eigen::Matrix2Xd& outline, double from, double to) {
  const std::vector<Eigen::Vector3i> cap = triangulate(outline);
  std::vector<Eigen::Matrix3Xd> rings;
  // seen along -y, from beyond `from`, x runs to the right and z up
  for (const double y : {to, from}) {
    Eigen::Matrix3Xd ring(3, outline.cols());
    ring.row(0) = outline.row(0);
    ring.row(1).setConstant(y);
    ring.row(2) = outline.row(1);
    rings.push_back(ring);
  }
  return close_rings(rings, cap);
}

SurfaceMesh revolve(const Eigen::Matrix2Xd& profile, int sides) {
  std::vector<Eigen::Matrix3Xd> rings;
  for (Eigen::Index i = 0; i < profile.cols(); ++i) {
    rings.push_back(circle(Eigen::Vector3d(0.0, 0.0, profile(1, i)),
                           Eigen::Vector3d::UnitX(),
                           Eigen::Vector3d::UnitY(),
                           profile(0, i),
                           sides));
  }
  return close_rings(rings, fan(sides));
}

SurfaceMesh sweep(const Eigen::Matrix3Xd& path, const Eigen::VectorXd& radii, int sides) {
  std::vector<Eigen::Matrix3Xd> rings;
  Eigen::Vector3d right = tangent(path, 0).unitOrthogonal();
  for (Eigen::Index i = 0; i < path.cols(); ++i) {
    const Eigen::Vector3d along = tangent(path, i);
    right = (right - along.dot(right) * along).normalized();  // carried along without twist
    rings.push_back(circle(path.col(i), right, along.cross(right), radii[i], sides));
  }
  return close_rings(rings, fan(sides));
}

SurfaceMesh ribbon(const Eigen::Matrix3Xd& path, const Eigen::VectorXd& widths, double thickness) {
  std::vector<Eigen::Matrix3Xd> rings;
  for (Eigen::Index i = 0; i < path.cols(); ++i) {
    const Eigen::Vector3d along = tangent(path, i);
    const Eigen::Vector3d across = along.cross(Eigen::Vector3d::UnitZ()).normalized();
    const Eigen::Vector3d half_width = 0.5 * widths[i] * across;
    const Eigen::Vector3d half_thickness = 0.5 * thickness * across.cross(along);
    Eigen::Matrix3Xd ring(3, 4);
    ring << -half_width - half_thickness, -half_width + half_thickness, half_width + half_thickness,
        half_width - half_thickness;
    ring.colwise() += path.col(i);
    rings.push_back(ring);
  }
  return close_rings(rings, fan(4));
}

SurfaceMesh join(const std::vector<SurfaceMesh>& surfaces) {
  Eigen::Index vertices = 0;
  Eigen::Index triangles = 0;
  for (const SurfaceMesh& surface : surfaces) {
    vertices += surface.vertices.cols();
    triangles += surface.triangles.cols();
  }
  SurfaceMesh all;
  all.vertices.resize(3, vertices);
  all.triangles.resize(3, triangles);
  vertices = 0;
  triangles = 0;
  for (const SurfaceMesh& surface : surfaces) {
    all.vertices.middleCols(vertices, surface.vertices.cols()) = surface.vertices;
    all.triangles.middleCols(triangles, surface.triangles.cols()) =
        surface.triangles.array() + static_cast<int>(vertices);
    vertices += surface.vertices.cols();
    triangles += surface.triangles.cols();
  }
  return all;
}

SurfaceMesh moved(SurfaceMesh surface, const Eigen::Vector3d& by) {
  surface.vertices.colwise() += by;
  return surface;
}

}  // namespace twang
