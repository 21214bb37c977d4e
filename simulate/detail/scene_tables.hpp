// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/toml_table.hpp"
#include "simulate/scene.hpp"

#include <filesystem>
#include <vector>

namespace twang::detail {

// The tables of a scene file; each throws InputError for what the contract does not allow.

/// @param folder  of the scene file, to which what it names is relative
[[nodiscard]] std::vector<SceneBody> read_bodies(const TomlTable& document,
                                                 const std::filesystem::path& folder);
[[nodiscard]] std::vector<SceneLoad> read_loads(const TomlTable& document, const Scene& scene);
[[nodiscard]] std::vector<SceneProbe> read_probes(const TomlTable& document, const Scene& scene);
[[nodiscard]] std::vector<SceneBaseMotion> read_base_motions(const TomlTable& document,
                                                             const Scene& scene,
                                                             const std::filesystem::path& folder);

}  // namespace twang::detail
