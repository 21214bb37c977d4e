// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/refine_material.hpp"

#include "calibrate/detail/followed_residuals.hpp"
#include "calibrate/detail/judge_refinement.hpp"
#include "core/error.hpp"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <functional>
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
    return detail::from_parameters() * all.topLeftCorner<2, 2>() *
           detail::from_parameters().transpose();
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

/// By its own weights, so that what the fit makes smaller is what is said to be left.
double weighed_rms(const VectorXd& weighed_residual, const detail::Samples& samples) {
  return std::sqrt(weighed_residual.squaredNorm() / samples.weight.squaredNorm());
}

/// All recordings on one E_n and b.
class FollowProblem {
 public:
  explicit FollowProblem(std::vector<std::unique_ptr<FollowedResiduals>> all)
      : m_all(std::move(all)), m_own(m_all.size(), {kStart, kStart}) {}

  [[nodiscard]] std::size_t size() const { return m_all.size(); }
  [[nodiscard]] const detail::Samples& samples(std::size_t i) const { return m_all[i]->samples(); }
  [[nodiscard]] Parameters parameters(std::size_t i) const {
    return from_blocks(m_shared.data(), m_own[i].data());
  }
  [[nodiscard]] ElasticMaterial material() const {
    return m_all.front()->material_at(parameters(0));
  }
  /// Of what failed last; empty: nothing.
  [[nodiscard]] std::string message() const {
    for (const auto& one : m_all)
      if (!one->message().empty()) return one->message();
    return {};
  }

  /// Weighed and without offset; nothing if the simulation fails.
  [[nodiscard]] std::optional<VectorXd> residual(std::size_t i) {
    const FollowedResiduals::Values* values = m_all[i]->values(parameters(i));
    if (values == nullptr) return {};
    return VectorXd(weighed(samples(i).value - values->simulated, samples(i)));
  }
  /// Likewise, d simulated / d parameters.
  [[nodiscard]] std::optional<MatrixXd> columns(std::size_t i) {
    const std::optional<MatrixXd> found = m_all[i]->derivatives(parameters(i));
    if (!found) return {};
    return weighed(*found, samples(i));
  }

  ceres::Solver::Summary solve(const RefineMaterialOptions& options) {
    std::exception_ptr stopped;
    ceres::Problem problem;
    for (std::size_t i = 0; i < size(); ++i)
      problem.AddResidualBlock(
          new FollowCost(*m_all[i], stopped), nullptr, m_shared.data(), m_own[i].data());
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
    return summary;
  }

  /// @return how many samples, of all recordings
  int leave_out_outliers() {
    int count = 0;
    for (std::size_t i = 0; i < size(); ++i) count += m_all[i]->leave_out_outliers(parameters(i));
    return count;
  }

 private:
  std::vector<std::unique_ptr<FollowedResiduals>> m_all;
  std::array<double, kNumShared> m_shared = {kStart, kStart};
  std::vector<std::array<double, kNumOwn>> m_own;
};

/// Of ln E_n and ln b, and how every recording is followed.
struct Followed {
  Eigen::Matrix2d covariance;
  std::vector<FollowedRecording> recordings;
};

/// Nothing if a simulation fails.
std::optional<Followed> look_at(FollowProblem& problem) {
  Followed out;
  Normal normal(problem.size());
  double squares = 0.0;
  double widening = 1.0;
  Index num_samples = 0;
  for (std::size_t i = 0; i < problem.size(); ++i) {
    const std::optional<MatrixXd> columns = problem.columns(i);
    const std::optional<VectorXd> left = problem.residual(i);
    if (!columns || !left) return {};
    normal.add(i, *columns);
    squares += left->squaredNorm();
    num_samples += problem.samples(i).num_used();
    FollowedRecording& one = out.recordings.emplace_back();
    one.start = FollowedResiduals::start_at(problem.parameters(i));
    one.num_samples = static_cast<int>(problem.samples(i).num_used());
    one.residual_rms = weighed_rms(*left, problem.samples(i));
    one.correlation = correlation_with_next(*left);
    // residuals that are each rho of the one before leave (1 - rho) / (1 + rho) of their number
    constexpr double kMostCorrelated = 0.98;
    const double rho = std::clamp(one.correlation, 0.0, kMostCorrelated);
    widening = std::max(widening, (1.0 + rho) / (1.0 - rho));
  }
  const double freedom = static_cast<double>(num_samples) - static_cast<double>(kNumShared) -
                         (kNumOwn + 1.0) * static_cast<double>(problem.size());
  const double variance = squares / std::max(freedom, 1.0) * widening;
  out.covariance = normal.covariance() * variance;
  Eigen::Array2d between = Eigen::Array2d::Zero();
  for (std::size_t i = 0; i < problem.size(); ++i)
    between += detail::variance_between_halves(*problem.columns(i), *problem.residual(i), variance);
  const auto count = static_cast<double>(problem.size());
  out.covariance.diagonal().array() += between / count;
  return out;
}

/// As the material file keeps it.
Refinement change_of(const Material& before,
                     const RefinedMaterial& after,
                     const std::vector<RefinedRecording>& recordings,
                     double end_s) {
  Refinement change;
  change.linear_youngs_modulus_numerical_pa = before.youngs_modulus_numerical_pa;
  change.linear_damping_stiffness_b_s = before.damping_stiffness_b_s;
  change.modulus_change_rel =
      after.youngs_modulus_numerical_pa / before.youngs_modulus_numerical_pa - 1.0;
  change.damping_change_rel = after.damping_stiffness_b_s / before.damping_stiffness_b_s - 1.0;
  change.modulus_sigma_rel = after.modulus_sigma_rel;
  change.damping_sigma_rel = after.damping_sigma_rel;
  const InversionResult& first = *recordings.front().inversion;
  change.periods = (end_s - first.time_origin_s) * first.modes.front().frequency_hz;
  change.amplitude = 0.0;
  change.residual_rel = 0.0;
  change.linear_residual_rel = 0.0;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const FollowedRecording& one = after.recordings[i];
    const double amplitude =
        one.start.amplitude * recordings[i].inversion->modes.front().channels.front().amplitude;
    change.amplitude = std::max(change.amplitude, amplitude);
    change.residual_rel = std::max(change.residual_rel, one.residual_rms / amplitude);
    change.linear_residual_rel = std::max(change.linear_residual_rel, one.linear_rms / amplitude);
    change.samples += one.num_samples;
  }
  change.simulations = after.simulations;
  return change;
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

void check_refinable(const Rig& rig, const std::string& column) {
  if (const std::string fault = column_fault(rig, column); !fault.empty())
    throw InputError(fmt::format("the trace's column {} {}", column, fault));
  if (rig.observable) return;
  throw InputError(fmt::format(
      "{}: [observable] is missing, must say where {} was seen: how large a motion is decides how "
      "the simulation bends",
      rig.file.string(),
      column));
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
  const auto give_up = [&](Termination termination, const std::string& why) {
    result.termination = termination;
    result.message = "The linear estimate was kept: " + why + ".";
    return result;
  };
  std::string stage;
  RefineMaterialOptions used = options;
  used.progress = [&](const Progress& progress) {
    return !options.progress || options.progress({stage, progress.done, progress.total});
  };
  const auto count = [&] { stage = fmt::format("refining, simulation {}", ++result.simulations); };
  std::vector<std::unique_ptr<FollowedResiduals>> all;
  for (const RefinedRecording& recording : recordings) {
    check_refinable(rig, recording.column);
    const auto& one = all.emplace_back(
        std::make_unique<FollowedResiduals>(rig, coarse, material, recording, mode, used, count));
    if (!one->samples().fault.empty())
      return give_up(Termination::NumericalFailure, one->samples().fault);
    const std::string hidden =
        detail::fault_of_view(one->follower().observable(), coarse.modes, mode);
    if (!hidden.empty()) return give_up(Termination::NumericalFailure, hidden);
  }

  FollowProblem problem(std::move(all));
  std::vector<VectorXd> linear;
  for (std::size_t i = 0; i < problem.size(); ++i) {
    const std::optional<VectorXd> left = problem.residual(i);
    if (!left) return give_up(Termination::NumericalFailure, problem.message());
    linear.push_back(*left);
  }
  ceres::Solver::Summary summary;
  try {
    summary = problem.solve(options);
    if (summary.termination_type == ceres::CONVERGENCE && problem.leave_out_outliers() > 0)
      summary = problem.solve(options);
  } catch (const NumericalFailure& failure) {
    return give_up(Termination::NumericalFailure, failure.what());
  }
  if (summary.termination_type != ceres::CONVERGENCE) {
    const bool out_of_patience = summary.termination_type == ceres::NO_CONVERGENCE;
    const std::string why = problem.message();
    return give_up(out_of_patience ? Termination::IterationLimit : Termination::NumericalFailure,
                   fmt::format("the refinement did not converge in {} iterations of {} "
                               "simulations{}",
                               summary.iterations.size(),
                               result.simulations,
                               why.empty() ? std::string() : ": " + why));
  }
  std::optional<Followed> followed = look_at(problem);
  if (!followed) return give_up(Termination::NumericalFailure, problem.message());
  const ElasticMaterial found = problem.material();
  result.youngs_modulus_numerical_pa = found.youngs_modulus_pa;
  result.damping_stiffness_b_s = found.damping_stiffness_b_s;
  result.modulus_sigma_rel = std::sqrt(followed->covariance(0, 0));
  result.damping_sigma_rel = std::sqrt(followed->covariance(1, 1));
  result.recordings = std::move(followed->recordings);
  for (std::size_t i = 0; i < problem.size(); ++i) {
    const VectorXd compared = (problem.samples(i).weight.array() > 0.0).select(linear[i], 0.0);
    result.recordings[i].linear_rms = weighed_rms(compared, problem.samples(i));
  }
  result.change = change_of(material, result, recordings, problem.samples(0).end_s);
  result.termination = Termination::Converged;
  detail::RefinementFit fit;
  fit.change = {std::log1p(result.change.modulus_change_rel),
                std::log1p(result.change.damping_change_rel)};
  fit.covariance = followed->covariance;
  fit.residual_rel = result.change.residual_rel;
  fit.linear_residual_rel = result.change.linear_residual_rel;
  if (const std::string fault = detail::fault_of(fit); !fault.empty())
    return give_up(Termination::Converged, fault);
  if (const std::string same = detail::agreement_of(fit); !same.empty()) {
    result.agrees = true;
    return give_up(Termination::Converged, same);
  }
  return result;
}

}  // namespace twang
