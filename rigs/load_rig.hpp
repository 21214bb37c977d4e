// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

#include <filesystem>

namespace twang {

/// What a command needs of a rig beyond `format` and `name`; the loader refuses a rig that lacks
/// it.
struct RigNeeds {
  bool part = false;        ///< materials and part
  bool clamp = false;       ///< at least one clamp
  bool film = false;        ///< markers and camera
  bool observable = false;  ///< an observable whose markers exist
};

/// Reads a rig file (TOML, format `twang-rig/1`); millimetres and grams become SI here and nowhere
/// else.
///
/// Every key is checked: an unknown one is an error that names file, line and the nearest known
/// key.
///
/// @throws InputError "FILE:LINE: KEY is VALUE, must be ..." for a file that cannot be read or
/// parsed, an unknown key, a
///         value of the wrong type or out of range, a missing key, a name used twice or never
///         defined, a marker that is not fixed and stands farther than 1 mm from the part's surface
[[nodiscard]] Rig load_rig(const std::filesystem::path& path, const RigNeeds& needs = {});

}  // namespace twang
