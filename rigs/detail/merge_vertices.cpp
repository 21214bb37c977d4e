// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/detail/merge_vertices.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace twang::detail {
namespace {

using Key = std::array<std::int64_t, 3>;

/// A hash table from keys to the vertices that have them, chained.
class KeyTable {
 public:
  explicit KeyTable(std::size_t num_vertices)
      : m_first(std::bit_ceil(2 * num_vertices + 1), -1), m_next(num_vertices, -1) {}

  void add(const Key& key, int vertex) {
    int& first = m_first[slot(key)];
    m_next[static_cast<std::size_t>(vertex)] = first;
    first = vertex;
  }
  /// The first vertex in the key's chain, which others may share, that `accepts`; -1 if none.
  template <typename Accepts>
  [[nodiscard]] int find(const Key& key, Accepts&& accepts) const {
    int vertex = m_first[slot(key)];
    while (vertex >= 0 && !accepts(vertex)) vertex = m_next[static_cast<std::size_t>(vertex)];
    return vertex;
  }

 private:
  [[nodiscard]] std::size_t slot(const Key& key) const {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;  // 2^64 over the golden ratio
    std::uint64_t hash = 0;
    for (const std::int64_t number : key) {
      hash = (hash ^ static_cast<std::uint64_t>(number)) * kGolden;
      hash ^= hash >> 29;
    }
    return static_cast<std::size_t>(hash) & (m_first.size() - 1);
  }
  std::vector<int> m_first;
  std::vector<int> m_next;
};

/// For each vertex the first one equal to it.
std::vector<int> first_equal(const Eigen::Matrix3Xd& vertices) {
  KeyTable table(static_cast<std::size_t>(vertices.cols()));
  std::vector<int> first(static_cast<std::size_t>(vertices.cols()));
  for (int v = 0; v < static_cast<int>(vertices.cols()); ++v) {
    Key key;
    for (int axis = 0; axis < 3; ++axis) {
      // the sum makes a positive zero of a negative one
      key[static_cast<std::size_t>(axis)] = std::bit_cast<std::int64_t>(vertices(axis, v) + 0.0);
    }
    const int equal =
        table.find(key, [&](int other) { return vertices.col(other) == vertices.col(v); });
    if (equal < 0) table.add(key, v);
    first[static_cast<std::size_t>(v)] = equal < 0 ? v : equal;
  }
  return first;
}

/// For each vertex the first one near it.
std::vector<int> first_near(const Eigen::Matrix3Xd& vertices, double tolerance_m) {
  KeyTable table(static_cast<std::size_t>(vertices.cols()));
  std::vector<int> first(static_cast<std::size_t>(vertices.cols()));
  const Eigen::Vector3d low = vertices.rowwise().minCoeff();
  for (int v = 0; v < static_cast<int>(vertices.cols()); ++v) {
    const Eigen::Vector3d place = (vertices.col(v) - low) / tolerance_m;
    const auto is_near = [&](int other) {
      return (vertices.col(other) - vertices.col(v)).lpNorm<Eigen::Infinity>() <= tolerance_m;
    };
    int near = -1;
    for (int around = 0; around < 27 && near < 0; ++around) {
      const Key key = {static_cast<std::int64_t>(std::floor(place.x())) + around % 3 - 1,
                       static_cast<std::int64_t>(std::floor(place.y())) + around / 3 % 3 - 1,
                       static_cast<std::int64_t>(std::floor(place.z())) + around / 9 - 1};
      near = table.find(key, is_near);
    }
    if (near < 0) {
      table.add({static_cast<std::int64_t>(std::floor(place.x())),
                 static_cast<std::int64_t>(std::floor(place.y())),
                 static_cast<std::int64_t>(std::floor(place.z()))},
                v);
    }
    first[static_cast<std::size_t>(v)] = near < 0 ? v : near;
  }
  return first;
}

}  // namespace

SurfaceMesh merge_vertices(const SurfaceMesh& surface, double tolerance_m) {
  const std::vector<int> first =
      tolerance_m > 0.0 ? first_near(surface.vertices, tolerance_m) : first_equal(surface.vertices);
  std::vector<int> number(first.size(), -1);
  SurfaceMesh merged;
  merged.triangles.resize(3, surface.triangles.cols());
  Eigen::Index num_triangles = 0;
  int num_vertices = 0;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    Eigen::Vector3i corners;
    for (int i = 0; i < 3; ++i) {
      corners[i] = first[static_cast<std::size_t>(surface.triangles(i, t))];
    }
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    for (int& corner : corners) {
      int& its_number = number[static_cast<std::size_t>(corner)];
      if (its_number < 0) its_number = num_vertices++;
      corner = its_number;
    }
    merged.triangles.col(num_triangles++) = corners;
  }
  merged.triangles.conservativeResize(3, num_triangles);
  merged.vertices.resize(3, num_vertices);
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] >= 0) {
      merged.vertices.col(number[v]) = surface.vertices.col(static_cast<Eigen::Index>(v));
    }
  }
  return merged;
}

}  // namespace twang::detail
