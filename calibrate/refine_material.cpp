// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/refine_material.hpp"

#include "calibrate/detail/followed_residuals.hpp"
#include "core/error.hpp"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>
#include <utility>

namespace twang {
namespace {

using detail::FollowedResiduals;
using detail::kNumOwn;
using detail::kNumShared;
using detail::Parameters;
using detail::weighed;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Ceres asks for steps that are small beside the parameters: so it sees them with 1 added.
constexpr double kStart = 1.0;
Parameters from_blocks(const double* shared, const double* own) {
  return Parameters(shared[0], shared[1], own[0], own[1]).array() - kStart;
}

/// For Ceres: the two shared parameters, then the two of the recording.
class FollowCost : public ceres::CostFunction {
 public:
  /// @param stopped  what was thrown, to be thrown again when Ceres has returned
  FollowCost(FollowedResiduals& residuals, std::exception_ptr& stopped)
      : m_residuals(residuals), m_stopped(stopped) {
    set_num_residuals(static_cast<int>(residuals.samples().value.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(kNumShared));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(kNumOwn));
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    if (!m_stopped) {
      try {
        return evaluate(from_blocks(blocks[0], blocks[1]), residuals, jacobians);
      } catch (...) {
        m_stopped = std::current_exception();
      }
    }
    // Ceres, which would print a line of its own about a failure, is led to its end: all is zero.
    std::fill_n(residuals, num_residuals(), 0.0);
    for (std::size_t k = 0; jacobians != nullptr && k < 2; ++k)
      if (jacobians[k] != nullptr) std::fill_n(jacobians[k], 2 * num_residuals(), 0.0);
    return true;
  }

 private:
  [[nodiscard]] bool evaluate(const Parameters& p, double* residuals, double** jacobians) const {
    const FollowedResiduals::Values* values = m_residuals.values(p);
    if (values == nullptr) return false;
    const detail::Samples& samples = m_residuals.samples();
    const Index n = samples.value.size();
    Eigen::Map<VectorXd>(residuals, n) = weighed(samples.value - values->simulated, samples);
    if (jacobians == nullptr) return true;
    const std::optional<MatrixXd> columns = m_residuals.derivatives(p);
    if (!columns) throw NumericalFailure(m_residuals.message());
    const MatrixXd all = -weighed(*columns, samples);
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;
    if (jacobians[0] != nullptr)
      Eigen::Map<RowMajor>(jacobians[0], n, kNumShared) = all.leftCols(kNumShared);
    if (jacobians[1] != nullptr)
      Eigen::Map<RowMajor>(jacobians[1], n, kNumOwn) = all.rightCols(kNumOwn);
    return true;
  }

  FollowedResiduals& m_residuals;
  std::exception_ptr& m_stopped;
};

/// Of the shared parameters and every recording's own, from the normal equations of all.
class Normal {
 public:
  explicit Normal(std::size_t num_recordings)
      : m_matrix(MatrixXd::Zero(size_of(num_recordings), size_of(num_recordings))) {}

  void add(std::size_t recording, const MatrixXd& columns) {
    const Eigen::Matrix4d own = columns.transpose() * columns;
    const Index at = size_of(recording);
    m_matrix.topLeftCorner<kNumShared, kNumShared>() += own.topLeftCorner<2, 2>();
    m_matrix.block<kNumShared, kNumOwn>(0, at) = own.topRightCorner<2, 2>();
    m_matrix.block<kNumOwn, kNumShared>(at, 0) = own.bottomLeftCorner<2, 2>();
    m_matrix.block<kNumOwn, kNumOwn>(at, at) = own.bottomRightCorner<2, 2>();
  }
  /// Of ln E_n and ln b, for residuals of unit variance.
  [[nodiscard]] Eigen::Matrix2d covariance() const {
    const MatrixXd all =
        m_matrix.ldlt().solve(MatrixXd::Identity(m_matrix.rows(), m_matrix.rows()));
    Eigen::Matrix2d from_parameters;  // ln b = p1 - p0 / 2
    from_parameters << 1.0, 0.0, -0.5, 1.0;
    return from_parameters * all.topLeftCorner<2, 2>() * from_parameters.transpose();
  }

 private:
  [[nodiscard]] static Index size_of(std::size_t num_recordings) {
    return kNumShared + kNumOwn * static_cast<Index>(num_recordings);
  }
  MatrixXd m_matrix;
};

double correlation_with_next(const VectorXd& residual) {
  const Index n = residual.size();
  const double square = residual.squaredNorm();
  return square > 0.0 ? residual.head(n - 1).dot(residual.tail(n - 1)) / square : 0.0;
}

void check_column(const Rig& rig,
                  const RefinedRecording& recording,
                  const TraceFollower& follower) {
  if (const std::string fault = column_fault(rig, recording.column); !fault.empty())
    throw InputError(fmt::format("the trace's column {} {}", recording.column, fault));
  if (follower.observable().is_rigs_own()) return;
  throw InputError(fmt::format(
      "{}: [observable] is missing, must say where {} was seen: how large a motion is decides how "
      "the simulation bends",
      rig.file.string(),
      recording.column));
}

FollowedRecording followed(FollowedResiduals& residuals, const Parameters& p) {
  const detail::Samples& samples = residuals.samples();
  const VectorXd left = weighed(samples.value - residuals.values(p)->simulated, samples);
  const auto n = static_cast<double>(left.size());
  FollowedRecording recording;
  recording.start = FollowedResiduals::start_at(p);
  recording.num_samples = static_cast<int>(left.size());
  recording.residual_rms = std::sqrt(left.cwiseQuotient(samples.weight).squaredNorm() / n);
  recording.correlation = correlation_with_next(left);
  return recording;
}

}  // namespace

void RefineMaterialOptions::check() const {
  constexpr double kFewestSteps = 20.0;
  if (!(periods >= 1.0 && std::isfinite(periods)))
    throw InputError(fmt::format("periods is {}, must be >= 1", periods));
  if (!(settling >= 0.0 && std::isfinite(settling)))
    throw InputError(fmt::format("settling is {}, must be >= 0", settling));
  if (!(steps_per_period >= kFewestSteps && std::isfinite(steps_per_period)))
    throw InputError(
        fmt::format("steps_per_period is {}, must be >= {}", steps_per_period, kFewestSteps));
  if (max_iterations < 1)
    throw InputError(fmt::format("max_iterations is {}, must be >= 1", max_iterations));
  if (!(relative_step > 0.0 && relative_step < 1.0))
    throw InputError(fmt::format("relative_step is {}, must lie between 0 and 1", relative_step));
}

RefinedMaterial refine_material(const Rig& rig,
                                const MeshRung& coarse,
                                const Material& material,
                                const std::vector<RefinedRecording>& recordings,
                                int mode,
                                const RefineMaterialOptions& options) {
  options.check();
  if (recordings.empty()) throw InputError("no recording is given, must be one or more");
  RefinedMaterial result;
  RefineMaterialOptions used = options;
  used.progress = [&](const Progress&) {
    return !options.progress ||
           options.progress({"refining, simulation", static_cast<double>(result.simulations), 0.0});
  };
  std::vector<std::unique_ptr<FollowedResiduals>> all;
  for (const RefinedRecording& recording : recordings) {
    all.push_back(std::make_unique<FollowedResiduals>(
        rig, coarse, material, recording, mode, used, [&] { ++result.simulations; }));
    check_column(rig, recording, all.back()->follower());
  }

  std::exception_ptr stopped;
  std::array<double, kNumShared> shared = {kStart, kStart};
  std::vector<std::array<double, kNumOwn>> own(all.size(), {kStart, kStart});
  const auto parameters = [&](std::size_t i) { return from_blocks(shared.data(), own[i].data()); };
  ceres::Problem problem;
  for (std::size_t i = 0; i < all.size(); ++i)
    problem.AddResidualBlock(
        new FollowCost(*all[i], stopped), nullptr, shared.data(), own[i].data());
  std::vector<double> linear_rms;
  const auto give_up = [&](std::string why) {
    result.termination = Termination::NumericalFailure;
    result.message = std::move(why);
    return result;
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i]->values(parameters(i)) == nullptr) return give_up(all[i]->message());
    linear_rms.push_back(followed(*all[i], parameters(i)).residual_rms);
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.max_num_iterations = options.max_iterations;
  solver.parameter_tolerance = options.relative_step;
  solver.function_tolerance = 1e-5;  // of the cost: a hundredth of a sigma of one of 100 samples
  solver.gradient_tolerance = 0.0;
  solver.initial_trust_region_radius = 1e6;  // the linear estimate is near
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (stopped) std::rethrow_exception(stopped);

  Normal normal(all.size());
  double squares = 0.0;
  double widening = 1.0;
  int num_samples = 0;
  double largest = 0.0;
  double residual_rel = 0.0;
  double linear_rel = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Parameters p = parameters(i);
    const std::optional<MatrixXd> columns = all[i]->derivatives(p);
    if (!columns) return give_up(all[i]->message());
    const detail::Samples& samples = all[i]->samples();
    normal.add(i, weighed(*columns, samples));
    squares += weighed(samples.value - all[i]->values(p)->simulated, samples).squaredNorm();
    FollowedRecording one = followed(*all[i], p);
    one.linear_rms = linear_rms[i];
    num_samples += one.num_samples;
    // residuals that are each rho of the one before leave (1 - rho) / (1 + rho) of their number
    constexpr double kMostCorrelated = 0.98;
    const double rho = std::clamp(one.correlation, 0.0, kMostCorrelated);
    widening = std::max(widening, std::sqrt((1.0 + rho) / (1.0 - rho)));
    const double amplitude =
        one.start.amplitude * recordings[i].inversion->modes.front().channels.front().amplitude;
    largest = std::max(largest, amplitude);
    residual_rel = std::max(residual_rel, one.residual_rms / amplitude);
    linear_rel = std::max(linear_rel, one.linear_rms / amplitude);
    result.recordings.push_back(one);
  }
  const double freedom = num_samples - static_cast<double>(kNumShared) -
                         (kNumOwn + 1.0) * static_cast<double>(all.size());
  const Eigen::Matrix2d covariance =
      normal.covariance() * (squares / std::max(freedom, 1.0)) * widening * widening;
  const ElasticMaterial found = all.front()->material_at(parameters(0));
  result.youngs_modulus_numerical_pa = found.youngs_modulus_pa;
  result.damping_stiffness_b_s = found.damping_stiffness_b_s;
  result.modulus_sigma_rel = std::sqrt(covariance(0, 0));
  result.damping_sigma_rel = std::sqrt(covariance(1, 1));
  Refinement& change = result.change;
  change.linear_youngs_modulus_numerical_pa = material.youngs_modulus_numerical_pa;
  change.linear_damping_stiffness_b_s = material.damping_stiffness_b_s;
  change.modulus_change_rel = found.youngs_modulus_pa / material.youngs_modulus_numerical_pa - 1.0;
  change.damping_change_rel = found.damping_stiffness_b_s / material.damping_stiffness_b_s - 1.0;
  change.modulus_sigma_rel = result.modulus_sigma_rel;
  change.damping_sigma_rel = result.damping_sigma_rel;
  change.periods = (all.front()->samples().end_s - recordings.front().inversion->time_origin_s) *
                   recordings.front().inversion->modes.front().frequency_hz;
  change.amplitude = largest;
  change.residual_rel = residual_rel;
  change.linear_residual_rel = linear_rel;
  change.samples = num_samples;
  change.simulations = result.simulations;
  switch (summary.termination_type) {
    case ceres::CONVERGENCE:
      result.termination = Termination::Converged;
      break;
    case ceres::NO_CONVERGENCE:
      result.termination = Termination::IterationLimit;
      break;
    default:
      result.termination = Termination::NumericalFailure;
  }
  if (!result.usable()) {
    std::string why;
    for (const auto& one : all)
      if (why.empty()) why = one->message();
    result.message =
        fmt::format("the refinement did not converge in {} iterations of {} simulations{}",
                    summary.iterations.size(),
                    result.simulations,
                    why.empty() ? std::string() : ": " + why);
  }
  return result;
}

}  // namespace twang
