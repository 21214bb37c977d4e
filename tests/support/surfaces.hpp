// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"
#include "rigs/rig.hpp"
#include "rigs/surface_mesh.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>

namespace twang::test {

/// A surface of u and v in [0, 1], closed in both, from num_u x num_v quadrilaterals.
template <typename Point>
[[nodiscard]] SurfaceMesh closed_in_both(int num_u, int num_v, Point&& point) {
  SurfaceMesh mesh;
  mesh.vertices.resize(3, num_u * num_v);
  mesh.triangles.resize(3, 2 * num_u * num_v);
  for (int v = 0; v < num_v; ++v) {
    for (int u = 0; u < num_u; ++u) {
      const int a = v * num_u + u;
      const int b = v * num_u + (u + 1) % num_u;
      const int c = (v + 1) % num_v * num_u + (u + 1) % num_u;
      const int d = (v + 1) % num_v * num_u + u;
      mesh.vertices.col(a) = point(static_cast<double>(u) / num_u, static_cast<double>(v) / num_v);
      mesh.triangles.col(2 * a) = Eigen::Vector3i(a, b, c);
      mesh.triangles.col(2 * a + 1) = Eigen::Vector3i(a, c, d);
    }
  }
  return mesh;
}

/// A torus around the z axis through `centre`.
[[nodiscard]] inline SurfaceMesh torus(
    const Eigen::Vector3d& centre, double ring_radius, double tube_radius, int num_u, int num_v) {
  return closed_in_both(num_u, num_v, [=](double u, double v) {
    const double ring = 2.0 * kPi * u;
    const double tube = 2.0 * kPi * v;
    const double r = ring_radius + tube_radius * std::cos(tube);
    return Eigen::Vector3d(centre + Eigen::Vector3d(r * std::cos(ring),
                                                    r * std::sin(ring),
                                                    tube_radius * std::sin(tube)));
  });
}

/// Its volume as it stands, 2 pi² R r² shrunk by the chords of ring and tube.
[[nodiscard]] inline double torus_volume(double R, double r, int num_u, int num_v) {
  // Prismatoids between two meridians that enclose the angle s: area A, centroid at R.
  const double s = 2.0 * kPi / num_u;
  const double area = 0.5 * num_v * r * r * std::sin(2.0 * kPi / num_v);
  return num_u * std::sin(s) * R * area;
}

/// A sphere from latitudes and longitudes; 4 pi R³ / 3 but for the chords.
[[nodiscard]] inline SurfaceMesh sphere(const Eigen::Vector3d& centre, double radius, int num) {
  SurfaceMesh mesh;
  const int around = 2 * num;
  mesh.vertices.resize(3, around * (num - 1) + 2);
  mesh.triangles.resize(3, 2 * around * (num - 1));
  const int bottom = around * (num - 1);
  const int top = bottom + 1;
  const auto at = [=](double polar, double longitude) {
    return Eigen::Vector3d(centre + radius * Eigen::Vector3d(std::sin(polar) * std::cos(longitude),
                                                             std::sin(polar) * std::sin(longitude),
                                                             -std::cos(polar)));
  };
  mesh.vertices.col(bottom) = at(0.0, 0.0);
  mesh.vertices.col(top) = at(kPi, 0.0);
  int t = 0;
  for (int row = 0; row + 1 < num; ++row) {
    for (int u = 0; u < around; ++u) {
      const int a = row * around + u;
      const int b = row * around + (u + 1) % around;
      mesh.vertices.col(a) = at(kPi * (row + 1) / num, 2.0 * kPi * u / around);
      if (row == 0) mesh.triangles.col(t++) = Eigen::Vector3i(bottom, b, a);
      if (row + 2 < num) {
        mesh.triangles.col(t++) = Eigen::Vector3i(a, b, b + around);
        mesh.triangles.col(t++) = Eigen::Vector3i(a, b + around, a + around);
      } else {
        mesh.triangles.col(t++) = Eigen::Vector3i(a, b, top);
      }
    }
  }
  return mesh;
}

/// The twelve triangles of a box.
[[nodiscard]] inline SurfaceMesh box_surface(const Box& box) {
  SurfaceMesh mesh;
  mesh.vertices.resize(3, 8);
  for (int v = 0; v < 8; ++v) {
    mesh.vertices.col(v) = Eigen::Vector3d((v & 1) != 0 ? box.max.x() : box.min.x(),
                                           (v & 2) != 0 ? box.max.y() : box.min.y(),
                                           (v & 4) != 0 ? box.max.z() : box.min.z());
  }
  mesh.triangles.resize(3, 12);
  mesh.triangles << 0, 0, 4, 4, 0, 0, 2, 2, 0, 0, 1, 1,  //
      3, 2, 5, 7, 1, 5, 6, 7, 4, 6, 3, 7,                //
      1, 3, 7, 6, 5, 4, 7, 3, 6, 2, 7, 5;
  return mesh;
}

/// Two or more surfaces as one, none of them changed.
[[nodiscard]] inline SurfaceMesh together(std::initializer_list<SurfaceMesh> surfaces) {
  SurfaceMesh all;
  for (const SurfaceMesh& surface : surfaces) {
    const Eigen::Index vertices = all.vertices.cols();
    const Eigen::Index triangles = all.triangles.cols();
    all.vertices.conservativeResize(3, vertices + surface.vertices.cols());
    all.vertices.rightCols(surface.vertices.cols()) = surface.vertices;
    all.triangles.conservativeResize(3, triangles + surface.triangles.cols());
    all.triangles.rightCols(surface.triangles.cols()) =
        surface.triangles.array() + static_cast<int>(vertices);
  }
  return all;
}

/// The same turned inside out.
[[nodiscard]] inline SurfaceMesh inside_out(SurfaceMesh surface) {
  surface.triangles.row(1).swap(surface.triangles.row(2));
  return surface;
}

/// Without the triangles from `first` on, `count` of them.
[[nodiscard]] inline SurfaceMesh without_triangles(const SurfaceMesh& surface,
                                                   Eigen::Index first,
                                                   Eigen::Index count) {
  SurfaceMesh rest = surface;
  rest.triangles.resize(3, surface.triangles.cols() - count);
  rest.triangles << surface.triangles.leftCols(first),
      surface.triangles.rightCols(surface.triangles.cols() - first - count);
  return rest;
}

}  // namespace twang::test
