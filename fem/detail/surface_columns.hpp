// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/surface_mesh.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace twang {

/// Where straight lines along z pass through a closed surface.
///
/// Decided in whole numbers: the surface is snapped to a grid of 2^30 steps across, and a line that
/// meets an edge or a corner counts as moved by (ε, ε²). So each line enters as often as it leaves,
/// whatever it meets [Edelsbrunner & Mücke 1990].
class SurfaceColumns {
 public:
  struct Crossing {
    double z;  ///< [m]
    int turn;  ///< +1 where the line, going up, enters; -1 where it leaves
  };

  /// @param x, y  of the lines, ascending [m]. O(triangles + lines in their boxes).
  SurfaceColumns(const SurfaceMesh& surface,
                 const std::vector<double>& x,
                 const std::vector<double>& y);

  /// Crossings of the line at (x[i], y[j]), ascending.
  [[nodiscard]] std::span<const Crossing> at(std::size_t i, std::size_t j) const;
  /// How often the surface winds around the point of height z on that line; what lies on the
  /// surface counts as just above it.
  [[nodiscard]] int winding(std::size_t i, std::size_t j, double z) const;

 private:
  struct Hit {
    std::size_t line;
    Crossing crossing;
  };
  void sort_into_lines(const std::vector<Hit>& hits);

  std::size_t m_num_x = 0;
  std::size_t m_num_y = 0;
  std::vector<std::size_t> m_start;  ///< by line, x fastest
  std::vector<Crossing> m_crossings;
};

}  // namespace twang
