// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/material.hpp"
#include "fem/hex_mesh.hpp"

#include <vector>

namespace twang {

/// @throws InputError unless there is one material for each name, each value is in its range, and
/// every element names one of them
void check_materials(const HexMesh& mesh, const std::vector<ElasticMaterial>& materials);

/// @throws InputError if the mesh says how full some of its elements are, but not all, or not > 0
void check_fill(const HexMesh& mesh);

}  // namespace twang
