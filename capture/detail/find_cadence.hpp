// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/doubled_frames.hpp"
#include "capture/detail/path.hpp"

#include <cstddef>
#include <vector>

namespace twang::detail {

/// Which frames repeat the one before because the film shows each picture twice or three times: all
/// but the first of each picture where the film does so wherever anything moves, else none. At four
/// frames a period every other frame of an honest film may stand where the one before stood, but
/// only for as long as their phase lets them.
/// @param likeness  one a frame
/// @param paths     of the markers, one sample a frame
[[nodiscard]] std::vector<bool> find_cadence(const std::vector<Likeness>& likeness,
                                             const std::vector<Path>& paths);

/// Of the frames first, first + step ... before `end`, how many differ from the one before.
[[nodiscard]] double count_different(const std::vector<Likeness>& likeness,
                                     std::size_t first,
                                     std::size_t end,
                                     std::size_t step = 1);

}  // namespace twang::detail
