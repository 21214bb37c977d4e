// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace twang {

/// Writes a simulation's state with its checksum; on return it is on the disk, whole, and an older
/// checkpoint is replaced only then.
/// @throws InputError if that fails
void write_checkpoint(const std::filesystem::path& path, std::string_view state);

/// The state that `write_checkpoint` wrote.
/// @throws InputError if there is no such file, it is no checkpoint, or damaged
[[nodiscard]] std::string read_checkpoint(const std::filesystem::path& path);

}  // namespace twang
