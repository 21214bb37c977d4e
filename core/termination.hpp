// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace twang {

/// Why an iteration stopped.
enum class Termination { NotRun, Converged, IterationLimit, NumericalFailure };

}  // namespace twang
