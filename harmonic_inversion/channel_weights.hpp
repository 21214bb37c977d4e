// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/inversion_window.hpp"
#include "harmonic_inversion/select_modes.hpp"

namespace twang {

/// Fills `weights` of an inversion, and says in notes and remarks which samples counted less.
void describe_weights(const InversionWindow& window,
                      const ModeSelection& selection,
                      InversionResult& out);

}  // namespace twang
