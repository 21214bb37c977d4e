// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/eigenmodes_multigrid.hpp"

#include "core/dense_algebra.hpp"
#include "core/error.hpp"
#include "fem/detail/first_lambda.hpp"
#include "fem/detail/lobpcg.hpp"
#include "fem/detail/multigrid_solver.hpp"
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

VectorXd random_vector(const VoxelBody& voxels, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  VectorXd v(voxels.size());
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    const double value = uniform(generator);
    v[i] = voxels.held()[static_cast<std::size_t>(i)] != 0 ? 0.0 : value;
  }
  return v;
}

MatrixXd apply_to_all(const VoxelOperator& A, const MatrixXd& X) {
  MatrixXd product(X.rows(), X.cols());
  for (Eigen::Index k = 0; k < X.cols(); ++k) product.col(k) = A(X.col(k));
  return product;
}

/// Exact rigid modes, M-orthonormal; none if they are not modes (under stress away from
/// equilibrium).
MatrixXd rigid_modes(const ElasticBody& body,
                     const FreeDofs& free,
                     const VectorXd& u,
                     const VoxelBody& voxels,
                     const VoxelOperator& K,
                     const VoxelOperator& M) {
  const MatrixXd motions = rigid_motions(body.mesh(), free, u);
  MatrixXd R(voxels.size(), motions.cols());
  for (Eigen::Index k = 0; k < R.cols(); ++k) R.col(k) = voxels.from_full(motions.col(k));
  if (R.cols() == 0) return R;
  R = orthonormalized(R, R.transpose() * apply_to_all(M, R));
  const VectorXd v = random_vector(voxels, 1);
  const double scale = K(v).norm() / v.norm() * R.norm();
  if (apply_to_all(K, R).norm() > kRigidResidual * scale) R.resize(voxels.size(), 0);
  return R;
}

/// Modes of the coarsest grid on the finest, then random vectors smoothed by a cycle.
MatrixXd start_block(Multigrid& multigrid,
                     const VoxelBody& voxels,
                     const VoxelOperator& M,
                     double sigma,
                     int num_rigid,
                     int count) {
  const int wanted = count + num_guards(count);
  int num_coarse = std::min(wanted + num_rigid, multigrid.coarsest_dofs() / 3);
  MatrixXd coarse;
  if (num_coarse > num_rigid) {
    const SparseMatrix coarse_mass = multigrid.coarsest_matrix({0.0, 0.0, 1.0});
    ShiftedProblem problem;
    problem.size = multigrid.coarsest_dofs();
    problem.sigma = -sigma;
    problem.known.resize(problem.size, 0);
    problem.apply_mass = [&](const VectorXd& x) { return VectorXd(coarse_mass * x); };
    problem.apply_solver = [&](const VectorXd& x) { return multigrid.solve_coarsest(x); };
    const LanczosResult found = find_smallest(problem, num_coarse, kStartTolerance);
    if (found.termination == Termination::Converged) coarse = found.vectors;
  }
  num_coarse = std::max(0, static_cast<int>(coarse.cols()) - num_rigid);
  MatrixXd start(voxels.size(), wanted + kRandomGuards);
  for (int k = 0; k < start.cols(); ++k) {
    start.col(k) = k < num_coarse
                       ? multigrid.prolong_from_coarsest(coarse.col(num_rigid + k))
                       : multigrid.cycle(M(random_vector(voxels, 2 + static_cast<unsigned>(k))));
  }
  return start;
}

double largest_residual(const VoxelOperator& K, const VoxelOperator& M, const LobpcgResult& found) {
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
  if (solver.kind == StiffnessSolverKind::Factor) return {false, ", by Cholesky factor as asked"};
  const double bytes = estimate_factor_bytes(free.size());
  if (!asked && bytes <= solver.max_factor_bytes) return {false, ", by Cholesky factor"};
  const std::string large = fmt::format("a factor would take about {:.2g} GB", 1e-9 * bytes);
  const int block = options.count + num_guards(options.count) + kRandomGuards;
  std::string fault = voxel_fault(body.mesh());
  if (fault.empty() && block > free.size() / kLeastDofsPerVector) {
    fault = "too many modes are wanted of it";
  }
  if (fault.empty()) {
    return {true, asked ? ", by multigrid as asked" : fmt::format(", by multigrid: {}", large)};
  }
  if (asked) throw InputError(fmt::format("multigrid does not fit the mesh: {}", fault));
  return {
      false,
      fmt::format(
          ", by Cholesky factor: {}, but on this mesh there is no multigrid: {}", large, fault)};
}

Eigenmodes compute_modes_by_multigrid(const ElasticBody& body,
                                      const FreeDofs& free,
                                      const EigenmodeOptions& options,
                                      const Eigen::VectorXd& u) {
  Eigenmodes modes;
  modes.solver = StiffnessSolverKind::Multigrid;
  report_progress(options.progress, {"preparing the multigrid", 0.0, 0.0});
  const VoxelBody voxels(body, free);
  const VoxelOperator K(body, voxels, {1.0, 0.0, 0.0}, u);
  const VoxelOperator M(body, voxels, {0.0, 0.0, 1.0}, {});
  const int num_movable = static_cast<int>(rigid_motions(body.mesh(), free, u).cols());
  const MatrixXd rigid = rigid_modes(body, free, u, voxels, K, M);
  const int num_rigid = std::min(options.count, static_cast<int>(rigid.cols()));
  const int num_sought = options.count - num_rigid;

  const double sigma = num_movable > 0 ? estimate_first_lambda(body) : 0.0;
  Multigrid multigrid(voxels, options.solver.max_coarse_dofs);
  if (multigrid.prepare({1.0, 0.0, sigma}) != SolveStatus::Ok) {
    modes.termination = Termination::NumericalFailure;
    modes.message = "the multigrid could not be prepared: its matrices are not positive definite";
    return modes;
  }
  LobpcgResult found;
  found.termination = Termination::Converged;
  found.vectors.resize(voxels.size(), 0);
  if (num_sought > 0) {
    PreconditionedProblem problem;
    problem.apply_stiffness = [&](const VectorXd& x) { return K(x); };
    problem.apply_mass = [&](const VectorXd& x) { return M(x); };
    problem.precondition = [&](const VectorXd& x) { return multigrid.cycle(x); };
    problem.known = rigid;
    LobpcgOptions lobpcg;
    lobpcg.count = num_sought;
    lobpcg.tolerance = kGapMargin * options.tolerance;
    lobpcg.progress = [&](int iteration, double) {
      report_progress(options.progress,
                      {"finding eigenmodes", static_cast<double>(iteration), 0.0});
    };
    found = find_smallest_preconditioned(
        problem, start_block(multigrid, voxels, M, sigma, num_movable, num_sought), lobpcg);
  }
  modes.termination = found.termination;
  modes.message = found.message;
  if (num_sought == 0) modes.message = fmt::format("{} rigid modes", num_rigid);
  if (!modes.usable()) return modes;

  modes.lambda_per_s2 = VectorXd::Zero(options.count);
  modes.lambda_per_s2.tail(num_sought) = found.lambda;
  MatrixXd all(voxels.size(), options.count);
  all << rigid.leftCols(num_rigid), found.vectors;
  modes.max_residual = largest_residual(K, M, found);
  modes.max_orthonormality_error =
      (all.transpose() * apply_to_all(M, all) - MatrixXd::Identity(options.count, options.count))
          .cwiseAbs()
          .maxCoeff();
  modes.shapes.resize(body.mesh().num_dofs(), options.count);
  for (int k = 0; k < options.count; ++k) modes.shapes.col(k) = voxels.to_full(all.col(k));
  return modes;
}

}  // namespace twang
