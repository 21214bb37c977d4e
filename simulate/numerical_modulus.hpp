// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/material.hpp"
#include "fem/hex_mesh.hpp"

#include <string>

namespace twang {

/// E_n makes one mesh move as the real part does, and no other: "belongs to a mesh of ..., must be
/// of ..." if `mesh` is another than that of `material`, else empty.
[[nodiscard]] std::string numerical_modulus_fault(const Material& material, const HexMesh& mesh);

}  // namespace twang
