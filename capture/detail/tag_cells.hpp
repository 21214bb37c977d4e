// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/marker_dictionary.hpp"

#include <vector>

namespace twang::detail {

/// The cells of a tag within its black border, row by row from the upper left, as printed; true
/// where it is ink.
///
/// @param tag  0 <= tag < dictionary.num_tags
[[nodiscard]] std::vector<bool> tag_cells(const MarkerDictionary& dictionary, int tag);

}  // namespace twang::detail
