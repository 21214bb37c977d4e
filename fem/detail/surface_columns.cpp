// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/surface_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace twang {
namespace {

/// Steps across the surface: products of two differences still fit into 64 bits.
constexpr double kSteps = 1 << 30;

struct Place {
  std::int64_t x;
  std::int64_t y;
};

/// Twice the area of the triangle a, b, p; positive if p lies left of the line from a to b.
std::int64_t area(const Place& a, const Place& b, const Place& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

/// Whether p, moved by (ε, ε²), lies left of the line from a to b, two different places.
bool is_left(const Place& a, const Place& b, const Place& p) {
  const std::int64_t twice = area(a, b, p);
  if (twice != 0) return twice > 0;
  return b.y != a.y ? b.y < a.y : b.x > a.x;
}

/// Maps one coordinate to whole steps.
struct Snap {
  double low = 0.0;
  double scale = 0.0;
  Snap(double from, double to) : low(from), scale(to > from ? kSteps / (to - from) : 0.0) {}
  [[nodiscard]] std::int64_t operator()(double value) const {
    // What lies beside the surface need not be told apart from what lies a step beside it.
    return static_cast<std::int64_t>(
        std::llround(std::clamp((value - low) * scale, -1.0, kSteps + 1.0)));
  }
};

std::vector<std::int64_t> snapped(const std::vector<double>& values, const Snap& snap) {
  std::vector<std::int64_t> result;
  result.reserve(values.size());
  for (const double value : values) result.push_back(snap(value));
  return result;
}

/// Numbers of the first line and one past the last in [low, high].
std::array<std::size_t, 2> lines_between(const std::vector<std::int64_t>& lines,
                                         std::int64_t low,
                                         std::int64_t high) {
  const auto first = std::lower_bound(lines.begin(), lines.end(), low);
  const auto last = std::upper_bound(first, lines.end(), high);
  return {static_cast<std::size_t>(first - lines.begin()),
          static_cast<std::size_t>(last - lines.begin())};
}

}  // namespace

SurfaceColumns::SurfaceColumns(const SurfaceMesh& surface,
                               const std::vector<double>& x,
                               const std::vector<double>& y)
    : m_num_x(x.size()), m_num_y(y.size()) {
  const Box box = bounds_of(surface);
  const Snap snap_x(box.min.x(), box.max.x());
  const Snap snap_y(box.min.y(), box.max.y());
  const std::vector<std::int64_t> lines_x = snapped(x, snap_x);
  const std::vector<std::int64_t> lines_y = snapped(y, snap_y);
  std::vector<Place> places;
  places.reserve(static_cast<std::size_t>(surface.vertices.cols()));
  for (Eigen::Index v = 0; v < surface.vertices.cols(); ++v) {
    places.push_back({snap_x(surface.vertices(0, v)), snap_y(surface.vertices(1, v))});
  }

  std::vector<Hit> hits;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    const Eigen::Vector3i corner = surface.triangles.col(t);
    const Place a = places[static_cast<std::size_t>(corner[0])];
    const Place b = places[static_cast<std::size_t>(corner[1])];
    const Place c = places[static_cast<std::size_t>(corner[2])];
    const std::int64_t whole = area(a, b, c);
    if (whole == 0) continue;  // seen edge-on
    const bool faces_up = whole > 0;
    const auto [i0, i1] =
        lines_between(lines_x, std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}));
    const auto [j0, j1] =
        lines_between(lines_y, std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}));
    const Eigen::Vector3d z(surface.vertices(2, corner[0]),
                            surface.vertices(2, corner[1]),
                            surface.vertices(2, corner[2]));
    for (std::size_t j = j0; j < j1; ++j) {
      for (std::size_t i = i0; i < i1; ++i) {
        const Place p = {lines_x[i], lines_y[j]};
        if (is_left(a, b, p) != faces_up || is_left(b, c, p) != faces_up ||
            is_left(c, a, p) != faces_up) {
          continue;
        }
        const Eigen::Vector3d shares(static_cast<double>(area(b, c, p)),
                                     static_cast<double>(area(c, a, p)),
                                     static_cast<double>(area(a, b, p)));
        hits.push_back(
            {j * m_num_x + i, {shares.dot(z) / static_cast<double>(whole), faces_up ? -1 : 1}});
      }
    }
  }
  sort_into_lines(hits);
}

void SurfaceColumns::sort_into_lines(const std::vector<Hit>& hits) {
  m_start.assign(m_num_x * m_num_y + 1, 0);
  for (const Hit& hit : hits) ++m_start[hit.line + 1];
  for (std::size_t line = 1; line < m_start.size(); ++line) m_start[line] += m_start[line - 1];
  m_crossings.resize(hits.size());
  std::vector<std::size_t> next(m_start.begin(), m_start.end() - 1);
  for (const Hit& hit : hits) m_crossings[next[hit.line]++] = hit.crossing;
  for (std::size_t line = 0; line + 1 < m_start.size(); ++line) {
    const auto begin = m_crossings.begin();
    std::sort(begin + static_cast<std::ptrdiff_t>(m_start[line]),
              begin + static_cast<std::ptrdiff_t>(m_start[line + 1]),
              [](const Crossing& a, const Crossing& b) { return a.z < b.z; });
  }
}

std::span<const SurfaceColumns::Crossing> SurfaceColumns::at(std::size_t i, std::size_t j) const {
  const std::size_t line = j * m_num_x + i;
  return {m_crossings.data() + m_start[line], m_start[line + 1] - m_start[line]};
}

int SurfaceColumns::winding(std::size_t i, std::size_t j, double z) const {
  int winding = 0;
  for (const Crossing& crossing : at(i, j)) {
    if (crossing.z > z) break;
    winding += crossing.turn;
  }
  return winding;
}

}  // namespace twang
