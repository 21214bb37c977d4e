// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/closed_surface.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "rigs/detail/merge_vertices.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>

namespace twang {
namespace {

/// Vertices this near, over the surface's size, are one if equal ones leave holes: above the
/// rounding of single precision, far below what a printer can make [-].
constexpr double kMergeTolerance = 1e-6;
/// A solid below this share of its box is none: rounding of flat surfaces [-].
constexpr double kSmallestVolume = 1e-9;

using Edge = std::array<int, 2>;

/// One side of a triangle; `ends` ascending, `forward` if the triangle passes it in that order.
struct EdgeUse {
  Edge ends;
  int triangle;
  bool forward;
};

std::vector<EdgeUse> sorted_edge_uses(const SurfaceMesh& mesh) {
  std::vector<EdgeUse> uses;
  uses.reserve(static_cast<std::size_t>(3 * mesh.triangles.cols()));
  for (int t = 0; t < static_cast<int>(mesh.triangles.cols()); ++t) {
    for (int i = 0; i < 3; ++i) {
      const int a = mesh.triangles(i, t);
      const int b = mesh.triangles((i + 1) % 3, t);
      uses.push_back({{std::min(a, b), std::max(a, b)}, t, a < b});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return a.ends != b.ends ? a.ends < b.ends : a.triangle < b.triangle;
  });
  return uses;
}

template <typename Action>
void for_each_edge(const std::vector<EdgeUse>& uses, Action&& action) {
  for (std::size_t begin = 0; begin < uses.size();) {
    std::size_t end = begin + 1;
    while (end < uses.size() && uses[end].ends == uses[begin].ends) ++end;
    action(begin, end);
    begin = end;
  }
}

/// Edges that keep the surface from enclosing anything.
struct OpenEdges {
  long holes = 0;  ///< of one triangle
  long walls = 0;  ///< of three, five, ... triangles
  Edge first = {0, 0};
  [[nodiscard]] bool any() const { return holes + walls > 0; }
};

OpenEdges find_open_edges(const std::vector<EdgeUse>& uses) {
  OpenEdges open;
  for_each_edge(uses, [&](std::size_t begin, std::size_t end) {
    if ((end - begin) % 2 == 0) return;
    if (!open.any()) open.first = uses[begin].ends;
    ++(end - begin == 1 ? open.holes : open.walls);
  });
  return open;
}

std::string in_mm(const Eigen::Vector3d& x) {
  const Eigen::Vector3d mm = x * kMillimetresPerMetre;
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", mm.x(), mm.y(), mm.z());
}

[[noreturn]] void refuse_open(const SurfaceMesh& mesh,
                              const OpenEdges& open,
                              const std::string& name) {
  std::string kinds;
  if (open.holes > 0) {
    kinds =
        fmt::format("{} edge{} only one triangle", open.holes, open.holes == 1 ? " has" : "s have");
  }
  if (open.walls > 0) {
    kinds += fmt::format("{}{} edge{} three triangles or another odd number",
                         kinds.empty() ? "" : " and ",
                         open.walls,
                         open.walls == 1 ? " has" : "s have");
  }
  throw InputError(
      fmt::format("{}: is not a closed surface: {}, the first from {} to {} mm; mend "
                  "it where it was drawn",
                  name,
                  kinds,
                  in_mm(mesh.vertices.col(open.first[0])),
                  in_mm(mesh.vertices.col(open.first[1]))));
}

/// Two triangles at an edge; `agree` if they pass it in opposite directions, as neighbours should.
struct Neighbours {
  int a;
  int b;
  bool agree;
};

/// Pairs the triangles of each edge, those that agree first: each piece that pairs connect is then
/// closed by itself.
std::vector<Neighbours> pair_neighbours(const std::vector<EdgeUse>& uses) {
  std::vector<Neighbours> pairs;
  pairs.reserve(uses.size() / 2);
  std::vector<int> forward;
  std::vector<int> backward;
  for_each_edge(uses, [&](std::size_t begin, std::size_t end) {
    forward.clear();
    backward.clear();
    for (std::size_t i = begin; i < end; ++i) {
      (uses[i].forward ? forward : backward).push_back(uses[i].triangle);
    }
    const std::size_t agreeing = std::min(forward.size(), backward.size());
    for (std::size_t i = 0; i < agreeing; ++i) pairs.push_back({forward[i], backward[i], true});
    const std::vector<int>& rest = forward.size() > backward.size() ? forward : backward;
    for (std::size_t i = agreeing; i + 1 < rest.size(); i += 2) {
      pairs.push_back({rest[i], rest[i + 1], false});
    }
  });
  return pairs;
}

/// The pieces of a surface, and which triangles to turn so that neighbours agree.
struct Shells {
  std::vector<int> of_triangle;
  std::vector<char> turned;  ///< by triangle
  int count = 0;
  bool one_sided = false;
};

Shells find_shells(int num_triangles, const std::vector<Neighbours>& pairs) {
  const auto at = [](int t) { return static_cast<std::size_t>(t); };
  std::vector<int> start(at(num_triangles) + 1, 0);
  for (const Neighbours& pair : pairs) {
    ++start[at(pair.a) + 1];
    ++start[at(pair.b) + 1];
  }
  for (std::size_t t = 1; t < start.size(); ++t) start[t] += start[t - 1];
  std::vector<int> pair_of(2 * pairs.size());
  std::vector<int> next(start.begin(), start.end() - 1);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    pair_of[at(next[at(pairs[p].a)]++)] = static_cast<int>(p);
    pair_of[at(next[at(pairs[p].b)]++)] = static_cast<int>(p);
  }

  Shells shells;
  shells.of_triangle.assign(at(num_triangles), -1);
  shells.turned.assign(at(num_triangles), 0);
  std::vector<int> members;
  for (int seed = 0; seed < num_triangles; ++seed) {
    if (shells.of_triangle[at(seed)] >= 0) continue;
    members.assign(1, seed);
    shells.of_triangle[at(seed)] = shells.count;
    std::size_t num_turned = 0;
    for (std::size_t m = 0; m < members.size(); ++m) {
      const int t = members[m];
      for (int i = start[at(t)]; i < start[at(t) + 1]; ++i) {
        const Neighbours& pair = pairs[at(pair_of[at(i)])];
        const int other = pair.a == t ? pair.b : pair.a;
        const char turned = pair.agree == (shells.turned[at(t)] == 0) ? 0 : 1;
        if (shells.of_triangle[at(other)] < 0) {
          shells.of_triangle[at(other)] = shells.count;
          shells.turned[at(other)] = turned;
          num_turned += static_cast<std::size_t>(turned);
          members.push_back(other);
        }
        shells.one_sided = shells.one_sided || shells.turned[at(other)] != turned;
      }
    }
    if (2 * num_turned > members.size()) {
      for (const int t : members) shells.turned[at(t)] ^= 1;
    }
    ++shells.count;
  }
  return shells;
}

double tetrahedron_volume(const SurfaceMesh& mesh, Eigen::Index t, const Eigen::Vector3d& apex) {
  const Eigen::Vector3d a = mesh.vertices.col(mesh.triangles(0, t)) - apex;
  const Eigen::Vector3d b = mesh.vertices.col(mesh.triangles(1, t)) - apex;
  const Eigen::Vector3d c = mesh.vertices.col(mesh.triangles(2, t)) - apex;
  return a.dot(b.cross(c)) / 6.0;
}

void turn_triangle(SurfaceMesh& mesh, Eigen::Index t) {
  std::swap(mesh.triangles(1, t), mesh.triangles(2, t));
}

/// Solid angle of triangle `t` seen from `x`, over 4 pi [Van Oosterom & Strackee 1983].
double share_of_view(const SurfaceMesh& mesh, Eigen::Index t, const Eigen::Vector3d& x) {
  const Eigen::Vector3d a = mesh.vertices.col(mesh.triangles(0, t)) - x;
  const Eigen::Vector3d b = mesh.vertices.col(mesh.triangles(1, t)) - x;
  const Eigen::Vector3d c = mesh.vertices.col(mesh.triangles(2, t)) - x;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2.0 * std::atan2(a.dot(b.cross(c)), below) / (4.0 * kPi);
}

/// Turns shells outwards; a shell may face inwards only within another, as the wall of a cavity.
class ShellTurner {
 public:
  ShellTurner(SurfaceMesh& mesh, const Shells& shells) : m_mesh(mesh), m_shells(shells) {
    const auto count = static_cast<std::size_t>(shells.count);
    m_volume.assign(count, 0.0);
    m_box.assign(count,
                 {Eigen::Vector3d::Constant(kInfinity), Eigen::Vector3d::Constant(-kInfinity)});
    const Eigen::Vector3d apex = mesh.vertices.col(0);
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t) {
      const std::size_t shell = shell_of(t);
      m_volume[shell] += tetrahedron_volume(mesh, t, apex);
      for (const int v : mesh.triangles.col(t)) {
        m_box[shell].min = m_box[shell].min.cwiseMin(mesh.vertices.col(v));
        m_box[shell].max = m_box[shell].max.cwiseMax(mesh.vertices.col(v));
      }
    }
  }

  /// @return how many shells were turned
  int turn_outwards() {
    // What encloses another shell is larger: from large to small, the shells around are settled.
    std::vector<std::size_t> order(m_volume.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return std::abs(m_volume[a]) > std::abs(m_volume[b]);
    });
    m_turned.assign(m_volume.size(), 0);
    for (std::size_t rank = 0; rank < order.size(); ++rank) {
      m_turned[order[rank]] = must_turn(order[rank], std::span(order).first(rank));
    }
    for (Eigen::Index t = 0; t < m_mesh.triangles.cols(); ++t) {
      if (m_turned[shell_of(t)] != 0) turn_triangle(m_mesh, t);
    }
    return static_cast<int>(std::count(m_turned.begin(), m_turned.end(), 1));
  }

 private:
  [[nodiscard]] std::size_t shell_of(Eigen::Index t) const {
    return static_cast<std::size_t>(m_shells.of_triangle[static_cast<std::size_t>(t)]);
  }

  /// A shell outside of all that is solid must face outwards; one within goes with the smallest one
  /// around it, be it a cavity there or a body in the body.
  [[nodiscard]] char must_turn(std::size_t shell, std::span<const std::size_t> larger) const {
    const std::vector<double> winding = windings_around(shell, larger);
    int around = 0;
    char of_smallest = 0;
    for (const std::size_t other : larger) {
      const int times = static_cast<int>(std::lround(winding[other]));
      if (times == 0) continue;
      around += m_turned[other] != 0 ? -times : times;
      of_smallest = m_turned[other];
    }
    return around <= 0 ? static_cast<char>(m_volume[shell] < 0.0) : of_smallest;
  }

  /// How often each larger shell, as it faces in the file, winds around a corner of `shell`.
  [[nodiscard]] std::vector<double> windings_around(std::size_t shell,
                                                    std::span<const std::size_t> larger) const {
    std::vector<double> winding(m_box.size(), 0.0);
    std::vector<char> may_enclose(m_box.size(), 0);
    bool any = false;
    for (const std::size_t other : larger) {
      may_enclose[other] = m_box[other].contains(m_box[shell].min, 0.0) &&
                           m_box[other].contains(m_box[shell].max, 0.0);
      any = any || may_enclose[other] != 0;
    }
    if (!any) return winding;
    Eigen::Index own = 0;
    while (shell_of(own) != shell) ++own;
    const Eigen::Vector3d x = m_mesh.vertices.col(m_mesh.triangles(0, own));
    for (Eigen::Index t = 0; t < m_mesh.triangles.cols(); ++t) {
      if (may_enclose[shell_of(t)] != 0) winding[shell_of(t)] += share_of_view(m_mesh, t, x);
    }
    return winding;
  }

  SurfaceMesh& m_mesh;
  const Shells& m_shells;
  std::vector<double> m_volume;
  std::vector<Box> m_box;
  std::vector<char> m_turned;
};

}  // namespace

double enclosed_volume(const SurfaceMesh& surface) {
  if (surface.vertices.cols() == 0) return 0.0;
  const Eigen::Vector3d apex = surface.vertices.col(0);
  double volume = 0.0;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    volume += tetrahedron_volume(surface, t, apex);
  }
  return volume;
}

ClosedSurface close_surface(const SurfaceMesh& surface, const std::string& name) {
  ClosedSurface closed;
  closed.mesh = detail::merge_vertices(surface, 0.0);
  std::vector<EdgeUse> uses = sorted_edge_uses(closed.mesh);
  if (find_open_edges(uses).any()) {
    const Box box = bounds_of(surface);
    const double tolerance = kMergeTolerance * (box.max - box.min).norm();
    if (tolerance > 0.0) closed.mesh = detail::merge_vertices(surface, tolerance);
    uses = sorted_edge_uses(closed.mesh);
    const OpenEdges open = find_open_edges(uses);
    if (open.any()) refuse_open(closed.mesh, open, name);
    closed.notes.push_back(
        fmt::format("{}: corners up to {:.3g} mm apart were joined, without which it has holes",
                    name,
                    tolerance * kMillimetresPerMetre));
  }
  const Shells shells =
      find_shells(static_cast<int>(closed.mesh.triangles.cols()), pair_neighbours(uses));
  if (shells.one_sided) {
    throw InputError(fmt::format(
        "{}: has one side only, as a Moebius strip; must have an inside and an outside", name));
  }
  closed.num_shells = shells.count;
  const auto num_turned = std::count(shells.turned.begin(), shells.turned.end(), 1);
  for (Eigen::Index t = 0; t < closed.mesh.triangles.cols(); ++t) {
    if (shells.turned[static_cast<std::size_t>(t)] != 0) turn_triangle(closed.mesh, t);
  }
  if (num_turned > 0) {
    closed.notes.push_back(
        fmt::format("{}: {} of {} triangles face another way than their "
                    "neighbours; they were turned",
                    name,
                    num_turned,
                    closed.mesh.triangles.cols()));
  }
  if (closed.num_shells > 0) {
    const int turned = ShellTurner(closed.mesh, shells).turn_outwards();
    if (turned > 0) {
      closed.notes.push_back(
          turned >= shells.count
              ? fmt::format("{}: is inside out; its triangles were turned", name)
              : fmt::format("{}: {} of its {} shells are inside out; their triangles were turned",
                            name,
                            turned,
                            shells.count));
    }
  }
  closed.volume_m3 = enclosed_volume(closed.mesh);
  const Box box = closed.num_shells > 0 ? bounds_of(closed.mesh) : Box{};
  if (!(closed.volume_m3 > kSmallestVolume * std::pow((box.max - box.min).maxCoeff(), 3))) {
    throw InputError(fmt::format("{}: encloses nothing, must be the surface of a solid", name));
  }
  return closed;
}

ClosedSurface read_closed_surface(const SurfaceFile& file) {
  return close_surface(read_surface(file), file.file.string());
}

}  // namespace twang
