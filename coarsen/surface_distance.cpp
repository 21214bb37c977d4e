// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/surface_distance.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <numeric>

namespace twang {
namespace {

using Eigen::Vector3d;

/// A tree of boxes over the triangles of one surface.
class TriangleTree {
 public:
  TriangleTree(const Eigen::Matrix3Xd& vertices, const std::vector<Triangle>& triangles)
      : m_vertices(vertices), m_triangles(triangles), m_order(triangles.size()) {
    std::iota(m_order.begin(), m_order.end(), 0);
    if (!m_order.empty()) build(0, static_cast<int>(m_order.size()));
  }

  /// Squared distance from `p`, known to be at most `bound` squared.
  [[nodiscard]] double squared_distance(const Vector3d& p, double bound) const {
    double best = bound * bound;
    if (!m_nodes.empty()) search(0, p, best);
    return best;
  }

 private:
  static constexpr int kLeafSize = 4;

  struct Node {
    Eigen::AlignedBox3d box;
    int begin = 0;
    int end = 0;
    int right = -1;  ///< -1: a leaf; the left child follows its parent
  };

  [[nodiscard]] Vector3d corner(int triangle, std::size_t i) const {
    return m_vertices.col(m_triangles[static_cast<std::size_t>(triangle)][i]);
  }

  int build(int begin, int end) {
    const auto index = static_cast<std::size_t>(m_nodes.size());
    m_nodes.push_back({});
    Eigen::AlignedBox3d box;
    for (int i = begin; i < end; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        box.extend(corner(m_order[static_cast<std::size_t>(i)], k));
      }
    }
    m_nodes[index].box = box;
    m_nodes[index].begin = begin;
    m_nodes[index].end = end;
    if (end - begin > kLeafSize) {
      Eigen::Index axis = 0;
      box.sizes().maxCoeff(&axis);
      const int middle = (begin + end) / 2;
      std::nth_element(m_order.begin() + begin,
                       m_order.begin() + middle,
                       m_order.begin() + end,
                       [&](int a, int b) { return centre(a, axis) < centre(b, axis); });
      build(begin, middle);
      const int right = build(middle, end);
      m_nodes[index].right = right;
    }
    return static_cast<int>(index);
  }

  [[nodiscard]] double centre(int triangle, Eigen::Index axis) const {
    return corner(triangle, 0)(axis) + corner(triangle, 1)(axis) + corner(triangle, 2)(axis);
  }

  void search(int index, const Vector3d& p, double& best) const {
    const Node& node = m_nodes[static_cast<std::size_t>(index)];
    if (node.box.squaredExteriorDistance(p) >= best) return;
    if (node.right >= 0) {
      search(index + 1, p, best);
      search(node.right, p, best);
      return;
    }
    for (int i = node.begin; i < node.end; ++i) {
      const int t = m_order[static_cast<std::size_t>(i)];
      const Vector3d q = closest_point_of_triangle(p, corner(t, 0), corner(t, 1), corner(t, 2));
      best = std::min(best, (q - p).squaredNorm());
    }
  }

  const Eigen::Matrix3Xd& m_vertices;
  const std::vector<Triangle>& m_triangles;
  std::vector<int> m_order;
  std::vector<Node> m_nodes;
};

/// Largest distance of a vertex of `from` to the surface of `to`. Vertices are asked in descending
/// order of the distance to their namesakes, which bounds theirs: below the largest distance found,
/// nothing is left to ask.
double directed_distance(const Eigen::Matrix3Xd& from,
                         const Eigen::Matrix3Xd& to,
                         const std::vector<Triangle>& triangles) {
  const TriangleTree tree(to, triangles);
  const Eigen::VectorXd bound = (from - to).colwise().norm();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(bound.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return bound(a) > bound(b); });
  double largest = 0.0;
  for (const Eigen::Index i : order) {
    if (bound(i) <= largest) break;
    largest = std::max(largest, std::sqrt(tree.squared_distance(from.col(i), bound(i))));
  }
  return largest;
}

Vector3d closest_point_of_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return a + t * ab;
}

}  // namespace

Vector3d closest_point_of_triangle(const Vector3d& p,
                                   const Vector3d& a,
                                   const Vector3d& b,
                                   const Vector3d& c) {
  const Vector3d normal = (b - a).cross(c - a);
  const double area2 = normal.squaredNorm();
  if (area2 > 0.0) {
    const double wa = (b - p).cross(c - p).dot(normal);
    const double wb = (c - p).cross(a - p).dot(normal);
    const double wc = (a - p).cross(b - p).dot(normal);
    if (wa >= 0.0 && wb >= 0.0 && wc >= 0.0) return (wa * a + wb * b + wc * c) / area2;
  }
  // Beside the triangle, or of no area: the nearest of its edges.
  Vector3d best = closest_point_of_segment(p, a, b);
  for (const Vector3d& q : {closest_point_of_segment(p, b, c), closest_point_of_segment(p, c, a)}) {
    if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
  }
  return best;
}

double hausdorff_distance(const Eigen::Matrix3Xd& first,
                          const Eigen::Matrix3Xd& second,
                          const std::vector<Triangle>& triangles) {
  return std::max(directed_distance(first, second, triangles),
                  directed_distance(second, first, triangles));
}

}  // namespace twang
