// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/eigenmodes_multigrid.hpp"

#include "core/dense_algebra.hpp"
#include "core/error.hpp"
#include "fem/detail/first_lambda.hpp"
#include "fem/detail/grid_problem.hpp"
#include "fem/detail/lobpcg.hpp"
#include "fem/detail/rigid_modes.hpp"
#include "fem/detail/shift_invert_lanczos.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace twang {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A rigid motion r counts as a mode if ‖K r‖ is below this part of what a random vector of its
/// length gives: round-off, not stiffness.
constexpr double kRigidResidual = 1e-9;
/// Vectors behind those wanted: of the coarse grid's, and at random; the latter meet whatever
/// symmetry the former lack.
constexpr int kMinGuards = 2;
constexpr int kGuardsPart = 4;  ///< at least one for so many wanted
constexpr int kRandomGuards = 2;
/// The block must stay small beside the problem.
constexpr int kLeastDofsPerVector = 20;
/// The error's estimate is to stay this far below the tolerance: the next eigenvalue outside of the
/// block may lie as near to the last one wanted as a hundredth of it.
constexpr double kGapMargin = 0.01;
/// Of the start's Ritz values; they err by far more.
constexpr double kStartTolerance = 1e-4;

int num_guards(int count) { return std::max(kMinGuards, count / kGuardsPart); }

VectorXd random_vector(const GridProblem& problem, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  VectorXd v(problem.size());
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    const double value = uniform(generator);
    v[i] = problem.held()[static_cast<std::size_t>(i)] != 0 ? 0.0 : value;
  }
  return v;
}

MatrixXd apply_to_all(const LinearMap& A, const MatrixXd& X) {
  MatrixXd product(X.rows(), X.cols());
  for (Eigen::Index k = 0; k < X.cols(); ++k) product.col(k) = A(X.col(k));
  return product;
}

/// Exact rigid modes, M-orthonormal; none if they are not modes (under stress away from
/// equilibrium).
MatrixXd rigid_modes(const ElasticBody& body,
                     const FreeDofs& free,
                     const VectorXd& u,
                     const GridProblem& problem,
                     const LinearMap& K,
                     const LinearMap& M) {
  const MatrixXd motions = rigid_motions(body.mesh(), free, u);
  MatrixXd R(problem.size(), motions.cols());
  for (Eigen::Index k = 0; k < R.cols(); ++k) R.col(k) = problem.from_full(motions.col(k));
  if (R.cols() == 0) return R;
  R = orthonormalized(R, R.transpose() * apply_to_all(M, R));
  const VectorXd v = random_vector(problem, 1);
  const double scale = K(v).norm() / v.norm() * R.norm();
  if (apply_to_all(K, R).norm() > kRigidResidual * scale) R.resize(problem.size(), 0);
  return R;
}

/// Modes of the coarsest grid on the finest, then random vectors smoothed by a cycle.
MatrixXd start_block(
    GridProblem& problem, const LinearMap& M, double sigma, int num_rigid, int count) {
  const int wanted = count + num_guards(count);
  int num_coarse = std::min(wanted + num_rigid, problem.coarsest_dofs() / 3);
  MatrixXd coarse;
  if (num_coarse > num_rigid) {
    const SparseMatrix coarse_mass = problem.coarsest_matrix({0.0, 0.0, 1.0});
    ShiftedProblem shifted;
    shifted.size = problem.coarsest_dofs();
    shifted.sigma = -sigma;
    shifted.known.resize(shifted.size, 0);
    shifted.apply_mass = [&](const VectorXd& x) { return VectorXd(coarse_mass * x); };
    shifted.apply_solver = [&](const VectorXd& x) { return problem.solve_coarsest(x); };
    const LanczosResult found = find_smallest(shifted, num_coarse, kStartTolerance);
    if (found.termination == Termination::Converged) coarse = found.vectors;
  }
  num_coarse = std::max(0, static_cast<int>(coarse.cols()) - num_rigid);
  MatrixXd start(problem.size(), wanted + kRandomGuards);
  for (int k = 0; k < start.cols(); ++k) {
    start.col(k) = k < num_coarse
                       ? problem.prolong_from_coarsest(coarse.col(num_rigid + k))
                       : problem.cycle(M(random_vector(problem, 2 + static_cast<unsigned>(k))));
  }
  return start;
}

double largest_residual(const LinearMap& K, const LinearMap& M, const LobpcgResult& found) {
  double largest = 0.0;
  for (Eigen::Index k = 0; k < found.lambda.size(); ++k) {
    const VectorXd K_phi = K(found.vectors.col(k));
    const VectorXd r = K_phi - found.lambda[k] * M(found.vectors.col(k));
    largest = std::max(largest, r.norm() / K_phi.norm());
  }
  return largest;
}

}  // namespace

MultigridChoice choose_multigrid(const ElasticBody& body,
                                 const FreeDofs& free,
                                 const EigenmodeOptions& options) {
  const StiffnessSolverOptions& solver = options.solver;
  const bool asked = solver.kind == StiffnessSolverKind::Multigrid;
  if (solver.kind == StiffnessSolverKind::Factor)
    return {false, false, ", by Cholesky factor as asked"};
  const double bytes = estimate_factor_bytes(free.size());
  const bool too_large = bytes > solver.max_factor_bytes;
  const bool slow =
      body.mesh().kind == ElementKind::Hex20 && free.size() > solver.max_quadratic_factor_dofs;
  if (!asked && !too_large && !slow) return {false, false, ", by Cholesky factor"};
  const std::string why = too_large
                              ? fmt::format("a factor would take about {:.2g} GB", 1e-9 * bytes)
                              : std::string("sooner than a factor of such elements");
  const int block = options.count + num_guards(options.count) + kRandomGuards;
  std::string fault = grid_fault(body.mesh());
  if (fault.empty() && block > free.size() / kLeastDofsPerVector) {
    fault = "too many modes are wanted of it";
  }
  if (fault.empty()) {
    return {true,
            !asked && !too_large,
            asked ? ", by multigrid as asked" : fmt::format(", by multigrid: {}", why)};
  }
  if (asked) throw InputError(fmt::format("multigrid does not fit the mesh: {}", fault));
  if (!too_large) return {false, false, ", by Cholesky factor"};
  return {false,
          false,
          fmt::format(
              ", by Cholesky factor: {}, but on this mesh there is no multigrid: {}", why, fault)};
}

Eigenmodes compute_modes_by_multigrid(const ElasticBody& body,
                                      const FreeDofs& free,
                                      const EigenmodeOptions& options,
                                      const Eigen::VectorXd& u) {
  Eigenmodes modes;
  modes.solver = StiffnessSolverKind::Multigrid;
  report_progress(options.progress, {"preparing the multigrid", 0.0, 0.0});
  const std::unique_ptr<GridProblem> problem =
      make_grid_problem(body, free, options.solver.max_coarse_dofs);
  const LinearMap K = problem->matrix({1.0, 0.0, 0.0}, u);
  const LinearMap M = problem->matrix({0.0, 0.0, 1.0}, {});
  const int num_movable = static_cast<int>(rigid_motions(body.mesh(), free, u).cols());
  const MatrixXd rigid = rigid_modes(body, free, u, *problem, K, M);
  const int num_rigid = std::min(options.count, static_cast<int>(rigid.cols()));
  const int num_sought = options.count - num_rigid;

  const double sigma = num_movable > 0 ? estimate_first_lambda(body) : 0.0;
  if (problem->prepare({1.0, 0.0, sigma}) != SolveStatus::Ok) {
    modes.termination = Termination::NumericalFailure;
    modes.message = "the multigrid could not be prepared: its matrices are not positive definite";
    return modes;
  }
  LobpcgResult found;
  found.termination = Termination::Converged;
  found.vectors.resize(problem->size(), 0);
  if (num_sought > 0) {
    PreconditionedProblem block;
    block.apply_stiffness = [&](const VectorXd& x) { return K(x); };
    block.apply_mass = [&](const VectorXd& x) { return M(x); };
    block.precondition = [&](const VectorXd& x) { return problem->cycle(x); };
    block.known = rigid;
    LobpcgOptions lobpcg;
    lobpcg.count = num_sought;
    lobpcg.tolerance = kGapMargin * options.tolerance;
    lobpcg.progress = [&](int iteration, double) {
      report_progress(options.progress,
                      {"finding eigenmodes", static_cast<double>(iteration), 0.0});
    };
    found = find_smallest_preconditioned(
        block, start_block(*problem, M, sigma, num_movable, num_sought), lobpcg);
  }
  modes.termination = found.termination;
  modes.message = found.message;
  if (num_sought == 0) modes.message = fmt::format("{} rigid modes", num_rigid);
  if (!modes.usable()) return modes;

  modes.lambda_per_s2 = VectorXd::Zero(options.count);
  modes.lambda_per_s2.tail(num_sought) = found.lambda;
  MatrixXd all(problem->size(), options.count);
  all << rigid.leftCols(num_rigid), found.vectors;
  modes.max_residual = largest_residual(K, M, found);
  modes.max_orthonormality_error =
      (all.transpose() * apply_to_all(M, all) - MatrixXd::Identity(options.count, options.count))
          .cwiseAbs()
          .maxCoeff();
  modes.shapes.resize(body.mesh().num_dofs(), options.count);
  for (int k = 0; k < options.count; ++k) modes.shapes.col(k) = problem->to_full(all.col(k));
  return modes;
}

}  // namespace twang
