// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace twang {

/// SHA-256 of a file's bytes, 64 lower-case hexadecimal digits.
/// @throws InputError if the file cannot be read
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& path);

/// SHA-256 of a text, 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256_of_text(std::string_view text);

}  // namespace twang
