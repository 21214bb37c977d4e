// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/refine_material.hpp"

#include "calibrate/detail/step_error.hpp"
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

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// ln E_n and ln (b sqrt E_n) over those of the linear estimate, then ln amplitude and phase of a
/// start: all 0 at the beginning.
constexpr Index kNumShared = 2;
constexpr Index kNumOwn = 2;
constexpr Index kNumParameters = kNumShared + kNumOwn;
using Parameters = Eigen::Matrix<double, kNumParameters, 1>;

/// Ceres asks for steps that are small beside the parameters: so it sees them with 1 added.
constexpr double kStart = 1.0;
Parameters from_blocks(const double* shared, const double* own) {
  return Parameters(shared[0], shared[1], own[0], own[1]).array() - kStart;
}

/// The samples of a recording that are followed.
struct Samples {
  VectorXd time_s;
  VectorXd value;   // in the column's unit
  VectorXd weight;  // 1 / sigma
  MatrixXd rest;    // orthonormal: what an offset, and perhaps a drift, adds to weighed samples
  double end_s = 0.0;
};

Samples samples_of(const RefinedRecording& recording, const RefineMaterialOptions& options) {
  const Trace& trace = *recording.trace;
  const InversionResult& inversion = *recording.inversion;
  const Channel& channel = *trace.find(recording.column);
  const Channel* offset_s = trace.time_offset_of(recording.column);
  const Channel* sigma = trace.sigma_of(recording.column);
  const double origin_s = inversion.time_origin_s;
  const double frequency_hz = inversion.modes.front().frequency_hz;
  Samples samples;
  samples.end_s = std::min(inversion.time_end_s, origin_s + options.periods / frequency_hz);
  const double begin_s = origin_s + options.settling / frequency_hz;
  std::vector<std::array<double, 3>> rows;
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    const double time = trace.time_s[i] + (offset_s == nullptr ? 0.0 : offset_s->values[i]);
    const double weight = sigma == nullptr ? 1.0 : 1.0 / sigma->values[i];
    if (!(time >= begin_s && time <= samples.end_s) || !std::isfinite(channel.values[i]) ||
        !std::isfinite(weight))
      continue;
    rows.push_back({time, channel.values[i], weight});
  }
  constexpr std::size_t kFewestSamples = 8;
  const double seen = (samples.end_s - begin_s) * frequency_hz;
  if (seen < 1.0)
    throw InputError(
        fmt::format("{}: {:.2f} of a period lie in the window from {:.4g} to {:.4g} s, must be one "
                    "or more to be refined",
                    recording.column,
                    seen,
                    begin_s,
                    samples.end_s));
  if (rows.size() < kFewestSamples)
    throw InputError(
        fmt::format("{}: {} samples lie in the first {:.3g} periods, must be {} or "
                    "more to be refined",
                    recording.column,
                    rows.size(),
                    seen,
                    kFewestSamples));
  const auto n = static_cast<Index>(rows.size());
  samples.time_s.resize(n);
  samples.value.resize(n);
  samples.weight.resize(n);
  for (Index i = 0; i < n; ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    samples.time_s[i] = row[0];
    samples.value[i] = row[1];
    samples.weight[i] = row[2];
  }
  MatrixXd rest = samples.weight;
  if (inversion.drifts_per_s[0] != 0.0) {
    rest.conservativeResize(n, 2);
    rest.col(1) = samples.weight.cwiseProduct((samples.time_s.array() - origin_s).matrix());
  }
  samples.rest = rest.householderQr().householderQ() * MatrixXd::Identity(n, rest.cols());
  return samples;
}

/// A curve through even samples and its slope: Catmull and Rom's cubics, which leave of a sinusoid
/// of n samples a period (2 pi / n)^4 / 100.
struct ValueAndSlope {
  double value = 0.0;
  double slope = 0.0;
};
ValueAndSlope smooth_at(const FollowedMotion& motion, double time_s) {
  const auto last = static_cast<std::ptrdiff_t>(motion.time_s.size()) - 1;
  const double position = (time_s - motion.time_s.front()) / motion.step_s;
  const auto i = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(position), 0, last - 1);
  const double x = position - static_cast<double>(i);
  const auto y = [&](std::ptrdiff_t k) { return motion.observable[static_cast<std::size_t>(k)]; };
  const double y0 = y(i);
  const double y1 = y(i + 1);
  // beyond either end the parabola through the last three
  const double before = i > 0 ? y(i - 1) : (last > 1 ? 3.0 * y0 - 3.0 * y1 + y(i + 2) : y0);
  const double after = i + 2 <= last ? y(i + 2) : 3.0 * y1 - 3.0 * y0 + before;
  const double m0 = 0.5 * (y1 - before);
  const double m1 = 0.5 * (after - y0);
  const double c2 = 3.0 * (y1 - y0) - 2.0 * m0 - m1;
  const double c3 = 2.0 * (y0 - y1) + m0 + m1;
  return {((c3 * x + c2) * x + m0) * x + y0, ((3.0 * c3 * x + 2.0 * c2) * x + m0) / motion.step_s};
}

/// The simulation beside the samples of a recording: residuals and their derivatives.
class FollowedResiduals {
 public:
  FollowedResiduals(const Rig& rig,
                    const MeshRung& coarse,
                    const Material& material,
                    const RefinedRecording& recording,
                    int mode,
                    const RefineMaterialOptions& options,
                    const std::function<void()>& simulated)
      : m_material(material),
        m_options(options),
        m_samples(samples_of(recording, options)),
        m_follower(rig, coarse, *recording.inversion, recording.column, mode),
        m_dilates(!rig.gravity_m_s2.has_value()),
        m_origin_s(recording.inversion->time_origin_s),
        m_simulated(simulated) {}

  struct Values {
    VectorXd simulated;
    VectorXd slope;  // its time derivative
  };

  [[nodiscard]] const Samples& samples() const { return m_samples; }
  [[nodiscard]] const TraceFollower& follower() const { return m_follower; }

  [[nodiscard]] ElasticMaterial material_at(const Parameters& p) const {
    ElasticMaterial elastic = {m_material.youngs_modulus_numerical_pa * std::exp(p[0]),
                               m_material.poissons_ratio,
                               m_material.density_kg_m3,
                               m_material.damping_stiffness_b_s * std::exp(p[1] - 0.5 * p[0]),
                               m_material.damping_mass_a_per_s};
    return elastic;
  }
  [[nodiscard]] static FollowedStart start_at(const Parameters& p) {
    return {std::exp(p[2]), p[3], std::exp(0.5 * p[0])};
  }

  /// nothing if the simulation fails; the reason is in `message`
  [[nodiscard]] const Values* values(const Parameters& p) {
    if (m_values && p == m_at) return &*m_values;
    std::optional<Values> found = simulate(p);
    if (!found) return nullptr;
    m_values = std::move(found);
    m_at = p;
    return &*m_values;
  }

  /// d simulated / d parameters, one row a sample.
  [[nodiscard]] std::optional<MatrixXd> derivatives(const Parameters& p) {
    const Values* here = values(p);
    if (here == nullptr) return {};
    // far below what a derivative changes over, far above the round-off of a simulation
    const Parameters steps(0.01, 0.02, 0.01, 0.01);
    constexpr double kHardlyMoved = 2.0;  // steps
    const bool kept =
        m_columns.size() != 0 &&
        ((p - m_columns_at).cwiseQuotient(steps)).cwiseAbs().maxCoeff() < kHardlyMoved;
    const Index first = m_dilates ? 1 : 0;
    if (!kept) {
      MatrixXd columns = MatrixXd::Zero(m_samples.value.size(), kNumParameters);
      const Values base = *here;
      for (Index k = first; k < kNumParameters; ++k) {
        Parameters moved = p;
        moved[k] += steps[k];
        const std::optional<Values> there = simulate(moved);
        if (!there) return {};
        columns.col(k) = (there->simulated - base.simulated) / steps[k];
      }
      m_columns = std::move(columns);
      m_columns_at = p;
    }
    MatrixXd all = m_columns;
    if (m_dilates)
      all.col(0) = 0.5 * (m_samples.time_s.array() - m_origin_s) * values(p)->slope.array();
    return all;
  }

  [[nodiscard]] const std::string& message() const { return m_message; }

 private:
  [[nodiscard]] std::optional<Values> simulate(const Parameters& p) {
    const ElasticMaterial elastic =
        detail::without_step_error(material_at(p), m_options.steps_per_period);
    if (m_simulated) m_simulated();
    const FollowedMotion motion = m_follower.follow(
        elastic, start_at(p), m_samples.end_s, m_options.steps_per_period, m_options.progress);
    if (!motion.run.usable()) {
      m_message = motion.run.message;
      return {};
    }
    Values values{VectorXd(m_samples.value.size()), VectorXd(m_samples.value.size())};
    for (Index i = 0; i < m_samples.value.size(); ++i) {
      const ValueAndSlope at = smooth_at(motion, m_samples.time_s[i]);
      values.simulated[i] = at.value;
      values.slope[i] = at.slope;
    }
    return values;
  }

  const Material& m_material;
  const RefineMaterialOptions& m_options;
  Samples m_samples;
  TraceFollower m_follower;
  bool m_dilates;
  double m_origin_s;
  std::function<void()> m_simulated;
  std::optional<Values> m_values;
  Parameters m_at = Parameters::Zero();
  MatrixXd m_columns;
  Parameters m_columns_at = Parameters::Zero();
  std::string m_message;
};

/// Rows times their weights, less what an offset explains of them.
MatrixXd weighed(const MatrixXd& rows, const Samples& samples) {
  const MatrixXd all = samples.weight.asDiagonal() * rows;
  return all - samples.rest * (samples.rest.transpose() * all);
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
    if (m_stopped) return false;
    try {
      return evaluate(from_blocks(blocks[0], blocks[1]), residuals, jacobians);
    } catch (...) {
      m_stopped = std::current_exception();
      return false;
    }
  }

 private:
  [[nodiscard]] bool evaluate(const Parameters& p, double* residuals, double** jacobians) const {
    const FollowedResiduals::Values* values = m_residuals.values(p);
    if (values == nullptr) return false;
    const Samples& samples = m_residuals.samples();
    const Index n = samples.value.size();
    Eigen::Map<VectorXd>(residuals, n) = weighed(samples.value - values->simulated, samples);
    if (jacobians == nullptr) return true;
    const std::optional<MatrixXd> columns = m_residuals.derivatives(p);
    if (!columns) return false;
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
  if (follower.observable().is_rigs_own()) return;
  throw InputError(fmt::format(
      "{}: [observable] is missing, must say where {} was seen: how large a motion is decides how "
      "the simulation bends",
      rig.file.string(),
      recording.column));
}

FollowedRecording followed(FollowedResiduals& residuals, const Parameters& p) {
  const Samples& samples = residuals.samples();
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
    const Samples& samples = all[i]->samples();
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
