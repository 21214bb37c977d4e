// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/trace.hpp"
#include "rigs/rig.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace twang::detail {

/// The columns of a trace that are inverted: those asked for, else the rig's observable, else
/// `default_columns`.
/// @throws InputError naming `file` if it lacks one that was asked for
[[nodiscard]] std::vector<std::string> columns_to_invert(const Rig& rig,
                                                         const Trace& trace,
                                                         const std::filesystem::path& file,
                                                         const std::vector<std::string>& asked);

}  // namespace twang::detail
