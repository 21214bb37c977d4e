// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"
#include "fem/static_solve.hpp"
#include "rigs/rig.hpp"

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace twang::bench {

[[nodiscard]] double seconds_since(std::chrono::steady_clock::time_point start);

/// Starts the count of the peak anew, where the system lets a process do so.
void reset_peak();
/// Largest resident set since then; 0 where the system does not tell [byte].
[[nodiscard]] double peak_bytes();

/// A rig's materials in the order of a mesh's names, E where the rig states none.
[[nodiscard]] std::vector<ElasticMaterial> materials_of(const Rig& rig,
                                                        const HexMesh& mesh,
                                                        double youngs_modulus_pa = 1e9,
                                                        double damping_stiffness_b_s = 0.0);

/// The rig's release as a load, `factor` times as far.
/// @throws InputError if it is none with a displacement
[[nodiscard]] StaticLoad pull_of_release(const Rig& rig, const HexMesh& mesh, double factor);

/// The exit code of `work`; 2 with its message on standard error if it throws.
[[nodiscard]] int exit_code_of(const std::function<int()>& work);

}  // namespace twang::bench
