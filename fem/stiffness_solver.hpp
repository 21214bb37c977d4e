// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"
#include "fem/linear_solver.hpp"

#include <Eigen/Core>

#include <memory>
#include <string>

namespace twang {

/// A = stiffness K(u) + damping D_K(u) + mass M, where D_K is K with each element scaled by its
/// material's b.
///
/// The matrix of a static step (1, 0, 0), of an implicit one of Newmark's (h²/4, h/2, 1), of a
/// shifted eigenproblem (1, 0, -sigma).
struct StiffnessCombination {
  double stiffness = 1.0;  ///< [-]
  double damping = 0.0;    ///< [1/s]
  double mass = 0.0;       ///< [1/s²]
};

enum class StiffnessSolverKind { Automatic, Factor, Multigrid };

struct StiffnessSolverOptions {
  StiffnessSolverKind kind = StiffnessSolverKind::Automatic;
  double tolerance = 1e-8;        ///< of an iterative solution, ‖b - A x‖ / ‖b‖ [-]
  int max_iterations = 300;       ///< of conjugate gradients, each one multigrid cycle
  double max_factor_bytes = 2e9;  ///< up to which estimate Automatic factorizes [byte]
  int max_coarse_dofs = 30'000;   ///< up to which the multigrid solves directly
  /// Up to which Automatic factorizes for the eigenmodes of hex20 though a larger factor may fit:
  /// above, multigrid is the faster way. Measured 1.8 against 1.1 s at 21,000 unknowns, 29 against
  /// 10 s at 170,000, 118 against 20 s at 370,000.
  int max_quadratic_factor_dofs = 20'000;
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// What a solution is worth; of several right-hand sides the worst.
struct StiffnessSolution {
  SolveStatus status = SolveStatus::NotFactorized;
  double relative_residual = 0.0;  ///< ‖b - A x‖ / ‖b‖, measured after the last iteration [-]
  int iterations = 0;              ///< 0: direct
  std::string message;             ///< one sentence for a person, empty if Ok
};

/// Solves A x = b on a body's free degrees of freedom, assembled and factorized or matrix-free.
class StiffnessSolver {
 public:
  virtual ~StiffnessSolver() = default;
  /// Takes A at displacement u (3 num_nodes, empty: undeformed). The multigrid's own cycles see
  /// the undeformed body and any u only through the conjugate gradients around them: the further
  /// u, the more of these. After a failure nothing can be solved.
  virtual SolveStatus prepare(const StiffnessCombination& of, const Eigen::VectorXd& u = {}) = 0;
  /// Solves A X = B, (free dofs x k). An indefinite A is reported, not solved: NotPositiveDefinite.
  virtual StiffnessSolution solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) = 0;
  [[nodiscard]] virtual StiffnessSolverKind kind() const = 0;  ///< Factor or Multigrid
  /// What it is, in a few words, and why it was chosen.
  [[nodiscard]] virtual std::string description() const = 0;
  [[nodiscard]] virtual double memory_bytes() const = 0;  ///< that it holds or will hold, estimated
};

/// Bytes that a Cholesky factor of a solid of hexahedra with so many free degrees of freedom takes;
/// a rough estimate, three-dimensional solids taking more than plates and strips.
[[nodiscard]] double estimate_factor_bytes(int num_free_dofs);

/// Makes a solver for a body; it keeps a reference to both. Multigrid needs a mesh of equal boxes
/// on a regular grid; Automatic takes it where the factor would need more than `max_factor_bytes`
/// and the mesh permits.
/// @throws InputError if Multigrid is asked for on another mesh
[[nodiscard]] std::unique_ptr<StiffnessSolver> make_stiffness_solver(
    const ElasticBody& body, const FreeDofs& free, const StiffnessSolverOptions& options = {});

}  // namespace twang
