// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/linear_solver.hpp"

#include <memory>

namespace twang {

/// The Cholesky solver with 32-bit indices; `analyze` answers OutOfMemory for a factor of more than
/// 2^31 entries.
[[nodiscard]] std::unique_ptr<LinearSolver> make_narrow_cholesky_solver();
/// The Cholesky solver with 64-bit indices, whatever the size.
[[nodiscard]] std::unique_ptr<LinearSolver> make_wide_cholesky_solver();

}  // namespace twang
