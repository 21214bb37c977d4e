// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/material.hpp"
#include "core/text.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace twang {

enum class TableFormat { Text, Csv, Markdown, Latex, Json };

/// @throws InputError for a name that is none of text, csv, markdown, latex, json
[[nodiscard]] TableFormat table_format_from(std::string_view name);

/// Calibrations as one material table in the layout of the paper's Fig. 20: material, reported,
/// identified with its sigma, numerical with its mesh, b with its sigma, frequency, tan delta.
///
/// Text, Markdown and LaTeX are for people: MPa, ms and Hz, a value rounded where its sigma's
/// second digit stands, to four digits where it has none; LaTeX needs the package booktabs. CSV and
/// JSON are for programs: SI under the keys of material.json, every digit; CSV has one line a
/// calibration with `nan` for what is not known, JSON is an array of material.json objects.
[[nodiscard]] std::string format_material_table(const std::vector<Material>& materials,
                                                TableFormat format);

}  // namespace twang
