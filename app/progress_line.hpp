// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/progress.hpp"

#include <string>

namespace twang::app {

/// One line that says how far a computation has come: what it does, a bar, per cent, and where what
/// is done can be counted ("frames") its rate and the time left.
///
/// @param prefix     said first ("film 2 of 5"); may be empty
/// @param elapsed_s  since this stage began [s]
[[nodiscard]] std::string progress_line(const std::string& prefix,
                                        const Progress& progress,
                                        double elapsed_s);

}  // namespace twang::app
