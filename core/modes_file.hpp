// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/damped_sinusoid.hpp"

#include <filesystem>
#include <vector>

namespace twang {

/// The damped sinusoids of a `modes.json` (format `twang-modes/1`), strongest first, without their
/// channels.
/// @throws InputError naming file and key if it cannot be read, is no JSON, is of another format,
/// holds several columns each with modes of its own, or a value of the wrong type or sign
[[nodiscard]] std::vector<DampedSinusoid> read_modes(const std::filesystem::path& path);

}  // namespace twang
