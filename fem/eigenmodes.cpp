// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/eigenmodes.hpp"

#include "core/constants.hpp"
#include "core/dense_algebra.hpp"
#include "core/error.hpp"
#include "fem/detail/eigenmodes_multigrid.hpp"
#include "fem/detail/first_lambda.hpp"
#include "fem/detail/rigid_modes.hpp"
#include "fem/detail/shift_invert_lanczos.hpp"
#include "fem/linear_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

/// A rigid motion r counts as a mode if ‖K r‖ is below this part of ‖diag(K) r‖: round-off, not
/// stiffness.
constexpr double kRigidResidual = 1e-9;
/// Eigenvalues of rigid modes below this part of the first elastic one are set to 0.
constexpr double kRigidLambda = 1e-6;
/// Problems up to this size are solved whole by dense matrices.
constexpr int kDenseSize = 150;
/// |sigma| stays above this part of the largest eigenvalue, so that K - sigma M can be factorized.
constexpr double kMinShift = 1e-10;
constexpr int kMaxShiftTrials = 10;

/// The free part of an eigenvalue problem.
struct FreeProblem {
  FreeDofs free;
  const SparseMatrix& full_mass;
  Eigen::MatrixXd rigid;  ///< exact rigid modes, M-orthonormal, (free x 0..6)
  int num_rigid = 0;      ///< that the held degrees of freedom permit

  /// M x; the whole mass matrix is used, to spare the memory of its free part.
  [[nodiscard]] Eigen::VectorXd apply_mass(const Eigen::VectorXd& x) const {
    return free.restrict_vector(full_mass * free.expand_vector(x));
  }
};

SparseMatrix shifted_stiffness(const ElasticBody& body,
                               const FreeDofs& free,
                               const Eigen::VectorXd& u,
                               double sigma) {
  SparseMatrix K = body.stiffness(u);
  if (sigma != 0.0) body.add_scaled_mass(-sigma, K);
  return free.size() == K.rows() ? K : free.restrict_matrix(K);
}

Eigen::MatrixXd apply_mass(const FreeProblem& problem, const Eigen::MatrixXd& X) {
  Eigen::MatrixXd MX(X.rows(), X.cols());
  for (int k = 0; k < X.cols(); ++k) MX.col(k) = problem.apply_mass(X.col(k));
  return MX;
}

/// Makes the columns of R M-orthonormal.
Eigen::MatrixXd orthonormalized(const Eigen::MatrixXd& R, const FreeProblem& problem) {
  return twang::orthonormalized(R, R.transpose() * apply_mass(problem, R));
}

FreeProblem make_free_problem(const ElasticBody& body,
                              const FreeDofs& free,
                              const Eigen::VectorXd& u) {
  FreeProblem problem{free, body.mass(), {}, 0};
  problem.rigid.resize(problem.free.size(), 0);
  const Eigen::MatrixXd motions = rigid_motions(body.mesh(), free, u);
  problem.num_rigid = static_cast<int>(motions.cols());
  if (problem.num_rigid == 0 || problem.free.size() == 0) return problem;

  const SparseMatrix K = shifted_stiffness(body, problem.free, u, 0.0);
  const Eigen::MatrixXd R =
      orthonormalized(motions(problem.free.full_from_free(), Eigen::all), problem);
  const double residual = (K * R).norm();
  const double scale = (Eigen::VectorXd(K.diagonal()).asDiagonal() * R).norm();
  // Under stress away from equilibrium a rotation is not a mode; then nothing is presumed.
  if (residual <= kRigidResidual * scale) problem.rigid = R;
  return problem;
}

void check_count(const EigenmodeOptions& options, const FreeDofs& free) {
  options.check();
  if (options.count <= free.size()) return;
  throw InputError(fmt::format("count is {}, must be <= {}, the number of free degrees of freedom",
                               options.count,
                               free.size()));
}

LanczosResult solve_dense(const SparseMatrix& K, const SparseMatrix& M, int count) {
  const SymmetricEigen eigen = symmetric_eigen(Eigen::MatrixXd(K), Eigen::MatrixXd(M));
  LanczosResult result;
  result.lambda = eigen.values.head(count);
  result.vectors = eigen.vectors.leftCols(count);
  const bool good = eigen.converged && result.lambda.allFinite();
  result.termination = good ? Termination::Converged : Termination::NumericalFailure;
  result.message = good ? fmt::format("{} modes of a dense problem", count)
                        : std::string("the dense eigenvalue problem could not be solved");
  return result;
}

/// The factor of K - sigma M.
struct ShiftedFactor {
  double sigma = 0.0;
  std::unique_ptr<LinearSolver> solver = make_cholesky_solver();
  SolveStatus status = SolveStatus::NotFactorized;
};

/// Factorizes with sigma = 0 where nothing can move rigidly, else, and where the stiffness is not
/// definite (a state beyond buckling), with the first sigma < 0 that works.
ShiftedFactor factorize_shifted(const ElasticBody& body,
                                const FreeProblem& problem,
                                const Eigen::VectorXd& u) {
  ShiftedFactor factor;
  double next_shift = 0.0;
  for (int trial = 0; trial < kMaxShiftTrials; ++trial) {
    if (trial > 0 || problem.num_rigid > 0) {
      if (next_shift == 0.0) {
        next_shift = estimate_first_lambda(body);
        const SparseMatrix K = shifted_stiffness(body, problem.free, u, 0.0);
        const Eigen::VectorXd ratio =
            K.diagonal().cwiseQuotient(problem.free.restrict_vector(body.mass().diagonal()));
        next_shift = std::max(next_shift, kMinShift * ratio.maxCoeff());
      }
      factor.sigma = -next_shift;
      next_shift *= 10.0;
    }
    const SparseMatrix A = shifted_stiffness(body, problem.free, u, factor.sigma);
    if (trial == 0) factor.status = factor.solver->analyze(A);
    if (trial > 0 || factor.status == SolveStatus::Ok) {
      factor.status = factor.solver->factorize(A);
    }
    if (factor.status != SolveStatus::NotPositiveDefinite) break;
  }
  return factor;
}

std::string factor_failure(SolveStatus status) {
  if (status == SolveStatus::OutOfMemory) return "the stiffness matrix does not fit into memory";
  if (status == SolveStatus::NotPositiveDefinite) {
    return "no shift makes the stiffness matrix positive definite";
  }
  return "the stiffness matrix could not be factorized";
}

/// `count` elastic modes, M-orthogonal to the rigid ones.
LanczosResult solve_sparse(const ElasticBody& body,
                           const FreeProblem& problem,
                           const Eigen::VectorXd& u,
                           int count,
                           const EigenmodeOptions& options) {
  report_progress(options.progress, {"factorizing the stiffness", 0.0, 0.0});
  const ShiftedFactor factor = factorize_shifted(body, problem, u);
  if (factor.status != SolveStatus::Ok) {
    LanczosResult failure;
    failure.termination = Termination::NumericalFailure;
    failure.message = factor_failure(factor.status);
    return failure;
  }
  int num_solves = 0;
  ShiftedProblem shifted;
  shifted.size = problem.free.size();
  shifted.sigma = factor.sigma;
  shifted.known = problem.rigid;
  shifted.apply_mass = [&](const Eigen::VectorXd& x) { return problem.apply_mass(x); };
  shifted.apply_solver = [&](const Eigen::VectorXd& x) {
    report_progress(options.progress,
                    {"finding eigenmodes", static_cast<double>(++num_solves), 0.0});
    Eigen::MatrixXd solution;
    factor.solver->solve(x, solution);
    return Eigen::VectorXd(solution);
  };
  LanczosResult result = find_smallest(shifted, count, options.tolerance);
  if (result.termination == Termination::Converged) {
    result.message = fmt::format("{} elastic modes in {} solves", count, num_solves);
  }
  return result;
}

/// Turns each shape so that its largest entry is positive: the same mesh gives the same shapes.
void fix_signs(Eigen::MatrixXd& shapes) {
  for (int k = 0; k < shapes.cols(); ++k) {
    Eigen::Index at = 0;
    shapes.col(k).cwiseAbs().maxCoeff(&at);
    if (shapes(at, k) < 0.0) shapes.col(k) *= -1.0;
  }
}

/// Counts the negative eigenvalues, which say that `u` is not stable, and says so.
void note_instability(Eigenmodes& modes) {
  modes.num_unstable = static_cast<int>((modes.lambda_per_s2.array() < 0.0).count());
  if (modes.num_unstable == 0) return;
  modes.message += fmt::format(
      "; {} of the eigenvalues {} negative: in this state the part or its elements buckle",
      modes.num_unstable,
      modes.num_unstable == 1 ? "is" : "are");
}

double largest_residual(const ElasticBody& body,
                        const FreeProblem& problem,
                        const Eigen::VectorXd& u,
                        const Eigenmodes& modes) {
  double largest = 0.0;
  for (int k = 0; k < modes.count(); ++k) {
    const double lambda = modes.lambda_per_s2[k];
    if (lambda == 0.0) continue;
    const Eigen::VectorXd shape = modes.shapes.col(k);
    const Eigen::VectorXd K_phi = problem.free.restrict_vector(body.stiffness_product(u, shape));
    const Eigen::VectorXd M_phi = problem.free.restrict_vector(body.mass() * shape);
    largest = std::max(largest, (K_phi - lambda * M_phi).norm() / K_phi.norm());
  }
  return largest;
}

/// Rigid eigenvalues that were computed, not presumed, are zero but for round-off.
void zero_rigid_lambda(Eigen::VectorXd& lambda, int num_rigid) {
  if (num_rigid == 0 || lambda.size() <= num_rigid) return;
  for (int k = 0; k < num_rigid; ++k) {
    if (std::abs(lambda[k]) < kRigidLambda * std::abs(lambda[num_rigid])) lambda[k] = 0.0;
  }
}

}  // namespace

void EigenmodeOptions::check() const {
  if (count < 1) throw InputError(fmt::format("count is {}, must be >= 1", count));
  if (!(tolerance > 0.0 && tolerance < 1e-2)) {
    throw InputError(fmt::format("tolerance is {}, must be > 0 and < 0.01", tolerance));
  }
  solver.check();
}

double Eigenmodes::natural_frequency_hz(int index) const {
  return std::sqrt(lambda_per_s2[index]) / kTwoPi;
}

Eigenmodes compute_eigenmodes(const ElasticBody& body,
                              const std::vector<int>& held_nodes,
                              const EigenmodeOptions& options,
                              const Eigen::VectorXd& u) {
  return compute_eigenmodes(body, FreeDofs(body.mesh().num_nodes(), held_nodes), options, u);
}

Eigenmodes compute_eigenmodes(const ElasticBody& body,
                              const FreeDofs& free,
                              const EigenmodeOptions& options,
                              const Eigen::VectorXd& u) {
  check_count(options, free);
  if (u.size() != 0 && !body.internal_force(u).allFinite()) {
    Eigenmodes none;
    none.termination = Termination::NumericalFailure;
    none.message =
        "the displacement turns elements inside out, or squeezes them until they collapse";
    return none;
  }
  MultigridChoice choice = choose_multigrid(body, free, options);
  if (choice.multigrid) {
    Eigenmodes modes = compute_modes_by_multigrid(body, free, options, u);
    if (modes.usable() || !choice.factor_fits) {
      modes.message += choice.reason;
      if (modes.usable()) {
        fix_signs(modes.shapes);
        note_instability(modes);
      }
      return modes;
    }
    choice.reason = fmt::format(", by Cholesky factor, as by multigrid {}", modes.message);
  }
  FreeProblem problem = make_free_problem(body, free, u);
  const int size = problem.free.size();
  const bool dense = size <= std::max(kDenseSize, 3 * options.count);
  if (dense) problem.rigid.resize(size, 0);
  const int num_presumed = std::min(options.count, static_cast<int>(problem.rigid.cols()));
  const int num_sought = options.count - num_presumed;

  LanczosResult found;
  found.termination = Termination::Converged;
  found.message = fmt::format("{} rigid modes", num_presumed);
  found.vectors.resize(size, 0);
  if (dense) {
    found = solve_dense(shifted_stiffness(body, problem.free, u, 0.0),
                        problem.free.restrict_matrix(body.mass()),
                        num_sought);
  } else if (num_sought > 0) {
    found = solve_sparse(body, problem, u, num_sought, options);
  }
  Eigenmodes modes;
  modes.termination = found.termination;
  modes.message = found.message;
  if (!modes.usable()) return modes;

  modes.lambda_per_s2 = Eigen::VectorXd::Zero(options.count);
  modes.lambda_per_s2.tail(num_sought) = found.lambda;
  modes.shapes = Eigen::MatrixXd::Zero(body.mesh().num_dofs(), options.count);
  for (int k = 0; k < options.count; ++k) {
    const Eigen::VectorXd shape = k < num_presumed
                                      ? Eigen::VectorXd(problem.rigid.col(k))
                                      : Eigen::VectorXd(found.vectors.col(k - num_presumed));
    modes.shapes.col(k) = problem.free.expand_vector(shape);
  }
  if (num_presumed == 0) zero_rigid_lambda(modes.lambda_per_s2, problem.num_rigid);
  fix_signs(modes.shapes);
  modes.max_residual = largest_residual(body, problem, u, modes);
  const Eigen::MatrixXd gram = modes.shapes.transpose() * (body.mass() * modes.shapes);
  modes.max_orthonormality_error =
      (gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff();
  modes.message += choice.reason;
  note_instability(modes);
  return modes;
}

}  // namespace twang
