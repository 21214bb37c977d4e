// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/eigenmodes.hpp"

#include <string>

namespace twang {

/// Which way the modes are found, and why, as an end of a sentence.
struct MultigridChoice {
  bool multigrid = false;
  bool factor_fits = false;  ///< where multigrid fails, a factor is left
  std::string reason;
};
/// @throws InputError if multigrid is asked for on a mesh that is no regular grid
[[nodiscard]] MultigridChoice choose_multigrid(const ElasticBody& body,
                                               const FreeDofs& free,
                                               const EigenmodeOptions& options);

/// Eigenmodes by LOBPCG with a multigrid cycle as preconditioner, from those of the coarsest grid;
/// rigid modes are known beforehand and kept out. Shapes have any sign.
[[nodiscard]] Eigenmodes compute_modes_by_multigrid(const ElasticBody& body,
                                                    const FreeDofs& free,
                                                    const EigenmodeOptions& options,
                                                    const Eigen::VectorXd& u);

}  // namespace twang
