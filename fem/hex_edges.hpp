// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace twang {

/// Corner nodes that span edge 8 + i of the quadratic hexahedron, VTK order.
inline constexpr std::array<std::array<int, 2>, 12> kHexEdges = {{{0, 1},
                                                                  {1, 2},
                                                                  {2, 3},
                                                                  {3, 0},
                                                                  {4, 5},
                                                                  {5, 6},
                                                                  {6, 7},
                                                                  {7, 4},
                                                                  {0, 4},
                                                                  {1, 5},
                                                                  {2, 6},
                                                                  {3, 7}}};

}  // namespace twang
