// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/load_rig.hpp"

#include <filesystem>

namespace twang::test {

/// rigs/strip.toml with what these uses of it need.
inline Rig sample_strip(const RigNeeds& needs = {.part = true, .clamp = true}) {
  return load_rig(std::filesystem::path(TWANG_SOURCE_DIR) / "rigs" / "strip.toml", needs);
}

}  // namespace twang::test
