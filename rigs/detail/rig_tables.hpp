// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/units.hpp"
#include "rigs/rig.hpp"
#include "rigs/toml_table.hpp"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace twang::detail {

// The tables of a rig file, read from the document; each throws InputError for what the contract
// does not allow. What `rig` already holds is what the table is checked against.

[[nodiscard]] std::map<std::string, std::string> read_specimen(const TomlTable& document);
[[nodiscard]] std::vector<RigMaterial> read_materials(const TomlTable& document);
/// @param folder  of the rig file, to which the surface files are relative
[[nodiscard]] std::vector<PartSolid> read_parts(const TomlTable& document,
                                                const std::vector<RigMaterial>& materials,
                                                const std::filesystem::path& folder);
[[nodiscard]] std::vector<Box> read_clamps(const TomlTable& document, const Rig& rig);
/// Checked against parts and materials.
[[nodiscard]] Meshing read_meshing(const TomlTable& document,
                                   const Rig& rig,
                                   const std::filesystem::path& folder);
/// Checked against the parts.
[[nodiscard]] std::vector<Marker> read_markers(const TomlTable& document, const Rig& rig);
[[nodiscard]] std::optional<Camera> read_camera(const TomlTable& document,
                                                const std::filesystem::path& folder);
/// Checked against the markers and the camera.
[[nodiscard]] std::optional<ObservableDefinition> read_observable(const TomlTable& document,
                                                                  const Rig& rig);

/// A position or an extent in millimetres, in metres.
[[nodiscard]] inline Eigen::Vector3d metres(const TomlTable& table, std::string_view key) {
  return table.vector(key) * kMetresPerMillimetre;
}
/// A length > 0 in millimetres, in metres.
[[nodiscard]] inline double positive_metres(const TomlTable& table, std::string_view key) {
  return table.positive(key) * kMetresPerMillimetre;
}

}  // namespace twang::detail
