// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/calibrate.hpp"

#include <vector>

namespace twang::detail {

/// The material of a calibration whose repeats are inverted, whose target is set and whose ladder
/// is built; its provenance and validation are left empty.
[[nodiscard]] Material material_of(const Rig& rig,
                                   const RigMaterial& unknown,
                                   const Calibration& calibration);

/// Puts what a refinement found in place of the linear estimate: E goes with E_n, the statistical
/// part of the budget is the refinement's.
void take_refinement(const RefinedMaterial& refined, Material& material);

/// Version, date, the files read and the options as used.
[[nodiscard]] Provenance provenance_of(const Rig& rig,
                                       const std::vector<Repeat>& repeats,
                                       const CalibrationOptions& options);

}  // namespace twang::detail
