// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/progress.hpp"
#include "core/termination.hpp"
#include "fem/elastic_body.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace twang {

struct EigenmodeOptions {
  int count = 10;            ///< smallest eigenvalues wanted, rigid modes included
  double tolerance = 1e-10;  ///< relative, of the Ritz values [-]
  ProgressCallback progress = {};
  /// Which solver: its kind, how large a factor may become, how coarse the coarsest grid is.
  StiffnessSolverOptions solver = {};
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// Free vibrations of a mesh, K phi = lambda M phi [paper, eq. (12)], ascending.
struct Eigenmodes {
  Eigen::VectorXd lambda_per_s2;  ///< (count) [1/s²]; rigid modes exactly 0
  Eigen::MatrixXd shapes;  ///< (3 num_nodes x count), mass-orthonormal, held nodes 0 [1/sqrt(kg)]
  double max_residual =
      0.0;  ///< largest ‖K phi - lambda M phi‖ / ‖K phi‖ over the elastic modes [-]
  Termination termination = Termination::NotRun;
  std::string message;  ///< one sentence for a person; names the solver and why it was chosen
  double max_orthonormality_error = 0.0;  ///< largest entry of |shapes' M shapes - 1| [-]
  StiffnessSolverKind solver = StiffnessSolverKind::Factor;  ///< that was used
  /// Negative eigenvalues among them: u is then no stable equilibrium, the part or its elements
  /// buckle there; the message says so.
  int num_unstable = 0;

  [[nodiscard]] bool usable() const { return termination == Termination::Converged; }
  [[nodiscard]] int count() const { return static_cast<int>(lambda_per_s2.size()); }
  /// sqrt(lambda) / 2 pi of mode `index` [Hz].
  [[nodiscard]] double natural_frequency_hz(int index) const;
};

/// Eigenmodes of K(u) with `held_nodes` at rest; a free body (no held node) has six rigid modes.
/// Each shape's largest entry is positive. Beyond buckling eigenvalues are negative and counted.
///
/// As long as a factor of K fits: ARPACK in shift-invert mode, one factorization and two to three
/// solves for each mode. On larger voxel meshes, and on those of hex20 above 20,000 unknowns, where
/// it is faster: LOBPCG, preconditioned by one multigrid cycle, ten to twenty cycles for each mode;
/// its shapes err by about the square root of the tolerance.
/// @param u  displacement at which the stiffness is taken (a prestressed state), (3 num_nodes) [m];
/// empty: undeformed
/// @throws InputError if more modes are wanted than the mesh has free degrees of freedom
[[nodiscard]] Eigenmodes compute_eigenmodes(const ElasticBody& body,
                                            const std::vector<int>& held_nodes,
                                            const EigenmodeOptions& options = {},
                                            const Eigen::VectorXd& u = {});
/// The same with single degrees of freedom held (rollers, planes of symmetry).
[[nodiscard]] Eigenmodes compute_eigenmodes(const ElasticBody& body,
                                            const FreeDofs& free,
                                            const EigenmodeOptions& options = {},
                                            const Eigen::VectorXd& u = {});

}  // namespace twang
