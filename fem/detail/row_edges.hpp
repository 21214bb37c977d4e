// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/cell_grid.hpp"

#include <cstddef>

namespace twang {

/// Points a kernel's row (`CellRow`, `DenseRow`) at the four edges of a row of cells, in vectors
/// that hold `num_nodes` values of each component, component by component.
template <class Row, class Real>
void point_at_edges(
    const CellGrid::Row& from, std::ptrdiff_t num_nodes, const Real* x, Real* y, Row& row) {
  row.length = from.length;
  for (int a = 0; a < 3; ++a) {
    for (int edge = 0; edge < 4; ++edge) {
      const auto at = a * num_nodes + from.first_node[static_cast<std::size_t>(edge)];
      row.x[a][edge] = x + at;
      row.y[a][edge] = y + at;
    }
  }
}

}  // namespace twang
