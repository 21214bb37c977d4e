// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/material.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace twang {

enum class TableFormat { Text, Csv, Markdown, Latex, Json };

/// @throws InputError for a name that is none of text, csv, markdown, latex, json
[[nodiscard]] TableFormat table_format_from(std::string_view name);

/// Calibrations as one material table in the layout of the paper's Fig. 20: material, reported,
/// identified with its sigma, numerical with its mesh, b with its sigma, frequency, tan delta. CSV
/// and JSON carry every digit.
[[nodiscard]] std::string format_material_table(const std::vector<Material>& materials,
                                                TableFormat format);

}  // namespace twang
