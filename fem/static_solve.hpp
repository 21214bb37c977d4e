// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/progress.hpp"
#include "core/termination.hpp"
#include "fem/elastic_body.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// A point whose displacement is prescribed along a direction, free across it.
struct PulledPoint {
  MeshPoint point;
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  ///< direction and length [m]
};

/// A load on a body: dead forces, and points whose displacements are prescribed.
struct StaticLoad {
  Eigen::VectorXd force;                  ///< (3 num_nodes) [N]; empty: none
  std::optional<MeshPoint> pulled_point;  ///< one of these
  Eigen::Vector3d pull =
      Eigen::Vector3d::Zero();  ///< displacement of that point: direction and length [m]
  std::vector<PulledPoint> more_pulls = {};  ///< further ones
};

/// The nodal forces (3 num_nodes) that a force `force_n` at `point` amounts to, by the shape
/// functions of its element [N].
[[nodiscard]] Eigen::VectorXd nodal_force(const HexMesh& mesh,
                                          const MeshPoint& point,
                                          const Eigen::Vector3d& force_n);

/// @param C  (dofs x k), of each pulled point `nodal_force` of its direction, 0 at held nodes
/// @throws InputError if a pulled point lies among held nodes, or those before hold it already
void check_pulls(const Eigen::MatrixXd& C);

struct StaticOptions {
  double tolerance = 1e-9;  ///< of the residual, relative to the largest internal force met [-]
  int max_newton_iterations = 60;  ///< within one load step
  int load_steps = 1;              ///< halved further by itself when Newton fails
  ProgressCallback progress = {};  ///< called per Newton iteration with the part of the load done
  StiffnessSolverOptions solver = {};  ///< a factor, or multigrid where that would be too large
  void check() const;                  ///< throws InputError naming field, value, allowed range
};

struct StaticResult {
  Eigen::VectorXd u;  ///< (3 num_nodes) [m]; of the last load that was balanced if not usable()
  Eigen::VectorXd
      reaction;  ///< internal minus applied force; not zero at held nodes and the pulled point [N]
  double pull_force_n = 0.0;   ///< that the first pulled point carries along its pull [N]
  double load_fraction = 0.0;  ///< part of the load that was balanced, 1 if usable() [-]
  double residual = 0.0;       ///< relative, as the tolerance is [-]
  int newton_iterations = 0;   ///< of all load steps, failed ones included
  int load_steps = 0;          ///< that were balanced
  Termination termination = Termination::NotRun;
  std::string message;        ///< one sentence for a person
  std::string solver;         ///< of the linear systems, and why it was chosen
  int linear_iterations = 0;  ///< of all linear systems solved; 0: direct
  /// Whether the stiffness there is positive definite. If not, forces balance but the part or its
  /// elements buckle at the slightest push, and the message says so. A pulled point is not asked:
  /// it can hold a part that would buckle under dead forces.
  bool stable = true;
  std::vector<double> pull_forces_n = {};  ///< of `pulled_point`, then of `more_pulls` [N]
  [[nodiscard]] bool usable() const { return termination == Termination::Converged; }
};

/// Static equilibrium of a body with `held_nodes` kept where they are: Newton with a line search on
/// the total potential energy.
///
///     minimize  W(u) - f . u   subject to   c . u = |pull|,   c = sum_i N_i(point) pull / |pull|
///
/// The constraints, one for each pull, are kept exactly, by their Lagrange multipliers (the forces
/// that `pull_forces_n` reports): each Newton step solves K for a right-hand side more than there
/// are pulls and takes the Schur complement. Load and constraints grow from those of `start`
/// (whatever holds it in place) in `load_steps` parts; a part that fails is halved. Where K is
/// indefinite the mass is added, times a shift that grows until the sum is definite, so that what
/// is found is a minimum. Residuals below the round-off of the internal force count as zero.
///
/// A body whose factor would be too large is balanced without any matrix, the linear systems being
/// solved by multigrid (`StaticOptions::solver`).
///
/// @param start  displacement to start from; empty: undeformed
/// @throws InputError if no node is held, sizes disagree, a point is pulled by nothing, or two
/// pulls hold the same
/// @throws Cancelled
[[nodiscard]] StaticResult solve_static(const ElasticBody& body,
                                        const std::vector<int>& held_nodes,
                                        const StaticLoad& load,
                                        const StaticOptions& options = {},
                                        const Eigen::VectorXd& start = {});

}  // namespace twang
