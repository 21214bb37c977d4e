// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/note.hpp"
#include "rigs/rig.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace twang::detail {

/// A warning for each marker that no frame shows and that nothing needs.
///
/// Needed is what the observable is made of; something that moves; where the rig has two fixed
/// markers or more, two of them, else its fixed one; without fixed ones, two markers to give the
/// scale, or all there are.
///
/// @param seen  one a marker: whether any frame shows it
/// @param film  its name, for the sentences
/// @throws InputError naming the marker if one is needed and never seen
[[nodiscard]] std::vector<Note> judge_unseen_markers(const Rig& rig,
                                                     const std::vector<bool>& seen,
                                                     const std::string& film,
                                                     std::size_t num_frames);

}  // namespace twang::detail
