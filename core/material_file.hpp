// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/material.hpp"

#include <filesystem>
#include <string>

namespace twang {

/// `material` as JSON text, format `twang-material/1`; every double reads back exactly, what is not
/// finite is `null`.
[[nodiscard]] std::string material_to_json(const Material& material);

/// Reads a `material.json`.
/// @throws InputError naming file and key if it cannot be read, is no JSON, is of another format,
/// lacks a required key
///         or holds a value of the wrong type or sign
[[nodiscard]] Material read_material(const std::filesystem::path& path);

/// Writes `material.json`; the file appears whole or not at all.
void write_material(const std::filesystem::path& path, const Material& material);

}  // namespace twang
