// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"

namespace twang {

/// Everything inside is SI; these factors stand at the user's edge (files and printed tables) and
/// nowhere else.
inline constexpr double kMetresPerMillimetre = 1e-3;
inline constexpr double kMillimetresPerMetre = 1e3;
inline constexpr double kKilogramsPerGram = 1e-3;
inline constexpr double kSecondsPerMillisecond = 1e-3;
inline constexpr double kRadiansPerDegree = kPi / 180.0;

}  // namespace twang
