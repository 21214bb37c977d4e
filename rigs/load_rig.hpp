// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

#include <filesystem>
#include <string>

namespace twang {

/// What a command needs of a rig beyond `format` and `name`; the loader refuses a rig that lacks
/// it.
struct RigNeeds {
  bool part = false;        ///< materials and part
  bool clamp = false;       ///< at least one clamp
  bool film = false;        ///< markers and camera
  bool observable = false;  ///< an observable whose markers exist
  bool mesh = false;        ///< materials, and a part or a mesh file
};

/// Reads a rig file (TOML, format `twang-rig/1`); millimetres and grams become SI here and nowhere
/// else.
///
/// Every key is checked: an unknown one is an error that names file, line and the nearest known
/// key. Tables of an array are counted from 1 ("marker.3.size_mm" of the third [[marker]]). The
/// path of a surface file is taken relative to the rig file, and the surface is read once to see
/// that it can be.
///
/// @throws InputError "FILE:LINE: KEY is VALUE, must be ..." for a file that cannot be read or
/// parsed, an unknown key, a value of the wrong type or out of range, a missing key, a name used
/// twice or never defined, an observable of markers that are all fixed, a clamp that does not touch
/// the box around the part, a marker that is not fixed and stands farther than 1 mm from the part's
/// surface (not asked of a rig with a surface file)
[[nodiscard]] Rig load_rig(const std::filesystem::path& path, const RigNeeds& needs = {});

/// The same from the text of a file.
///
/// @param file  its name, for messages, and the place to which its surface files are relative
[[nodiscard]] Rig parse_rig(const std::string& content,
                            const std::filesystem::path& file,
                            const RigNeeds& needs = {});

}  // namespace twang
