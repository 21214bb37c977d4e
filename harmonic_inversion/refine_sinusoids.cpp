// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/refine_sinusoids.hpp"

#include "core/constants.hpp"
#include "core/dense_algebra.hpp"
#include "core/error.hpp"
#include "harmonic_inversion/even_record.hpp"
#include "harmonic_inversion/projected_fit.hpp"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Beyond this many decay constants a sample per step a pole is a single spike.
constexpr double kMaxDecayPerSample = 4.0;

/// The series with the options that say how they are fitted.
class Model {
 public:
  Model(const std::vector<SampleSeries>& series, const RefineOptions& options)
      : m_series(series), m_options(options), m_records(options.records) {
    if (!m_records.empty()) return;
    for (std::size_t c = 0; c < series.size(); ++c) {
      const auto record = EvenRecord::from(series[c], weights(c));
      m_own.push_back(record ? std::make_unique<const EvenRecord>(*record) : nullptr);
      m_records.push_back(m_own.back().get());
    }
  }

  [[nodiscard]] const std::vector<SampleSeries>& series() const { return m_series; }
  [[nodiscard]] const RefineOptions& options() const { return m_options; }

  [[nodiscard]] ProjectedFit project(std::size_t c,
                                     const std::vector<DampedPole>& poles,
                                     bool with_derivatives) const {
    const bool drift = m_options.fit_drift;
    if (m_records[c] == nullptr)
      return fit_projected(m_series[c], weights(c), poles, drift, with_derivatives);
    if (auto fit = m_records[c]->fit_projected(poles, drift, with_derivatives)) return *fit;
    return fit_projected(m_series[c], m_records[c]->weights(), poles, drift, with_derivatives);
  }

  [[nodiscard]] VectorXd residual(std::size_t c,
                                  const std::vector<DampedPole>& poles,
                                  const VectorXd& coefficients) const {
    const SampleSeries& s = m_series[c];
    const bool drift = m_options.fit_drift;
    if (m_records[c] && EvenRecord::can_evaluate(poles, duration_of(s)))
      return s.value - m_records[c]->evaluate_model(poles, drift, coefficients);
    return s.value - evaluate_model(s, poles, drift, coefficients);
  }

  [[nodiscard]] Index num_used(std::size_t c) const {
    if (m_records[c]) return m_records[c]->num_used();
    const VectorXd& w = weights(c);
    return w.size() == 0 ? m_series[c].value.size() : (w.array() > 0.0).count();
  }

  [[nodiscard]] bool keeps_residual(std::size_t c) const {
    return m_options.keep_residuals || m_records[c] == nullptr;  // it is cheap there
  }

  /// Of the unweighted residual where the weight is above 0.
  [[nodiscard]] double sum_of_squares(std::size_t c,
                                      const ProjectedFit& fit,
                                      const VectorXd& residual) const {
    if (m_records[c]) return fit.sum_of_squares / std::pow(m_records[c]->weight(), 2);
    const VectorXd& w = weights(c);
    return w.size() == 0 ? residual.squaredNorm()
                         : (w.array() > 0.0).select(residual, 0.0).squaredNorm();
  }

 private:
  [[nodiscard]] const VectorXd& weights(std::size_t c) const {
    static const VectorXd kNone;
    return m_options.weights.empty() ? kNone : m_options.weights[c];
  }

  const std::vector<SampleSeries>& m_series;
  const RefineOptions& m_options;
  std::vector<std::unique_ptr<const EvenRecord>> m_own;
  std::vector<const EvenRecord*> m_records;  // one a channel, null: not long or even
};

std::vector<DampedPole> poles_from(const double* parameters, std::size_t count) {
  std::vector<DampedPole> poles(count);
  for (std::size_t k = 0; k < count; ++k) poles[k] = {parameters[2 * k], parameters[2 * k + 1]};
  return poles;
}

/// The projected residual as a function of the poles alone, turned so that only as many components
/// as parameters, and one more, differ from zero: cost, gradient and J^T J are those of all
/// samples.
///
///     J^T J = R^T R,   J' = [R; 0],   r' = [R^-T J^T r; what is left of ‖r‖]
class ProjectedResidual : public ceres::CostFunction {
 public:
  ProjectedResidual(const Model& model, std::size_t num_poles)
      : m_model(model), m_num_poles(num_poles) {
    set_num_residuals(static_cast<int>(2 * num_poles + 1));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(2 * num_poles));
  }

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const std::vector<DampedPole> poles = poles_from(parameters[0], m_num_poles);
    const bool derivatives = jacobians != nullptr && jacobians[0] != nullptr;
    const auto n = 2 * static_cast<Index>(m_num_poles);
    MatrixXd normal = MatrixXd::Zero(n, n);
    VectorXd gradient = VectorXd::Zero(n);
    double squares = 0.0;
    for (std::size_t c = 0; c < m_model.series().size(); ++c) {
      const ProjectedFit fit = m_model.project(c, poles, derivatives);
      squares += fit.sum_of_squares;
      if (!derivatives) continue;
      normal += fit.normal;
      gradient += fit.gradient;
    }
    if (!std::isfinite(squares) || !normal.allFinite()) return false;
    Eigen::Map<VectorXd> turned(residuals, n + 1);
    turned.setZero();
    turned(n) = std::sqrt(squares);
    if (!derivatives) return true;
    const MatrixXd r = regular_triangle(normal);
    turned.head(n) = r.transpose().triangularView<Eigen::Lower>().solve(gradient);
    turned(n) = std::sqrt(std::max(squares - turned.head(n).squaredNorm(), 0.0));
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> jacobian(jacobians[0], n + 1, n);
    jacobian.setZero();
    jacobian.topRows(n) = r;
    return true;
  }

 private:
  const Model& m_model;
  std::size_t m_num_poles;
};

/// The positions of the (f, d) parameters that move.
std::vector<Index> free_parameters(std::size_t num_poles, const std::vector<bool>& fixed_decays) {
  std::vector<Index> out;
  for (std::size_t k = 0; k < num_poles; ++k) {
    out.push_back(2 * static_cast<Index>(k));
    if (fixed_decays.empty() || !fixed_decays[k]) out.push_back(2 * static_cast<Index>(k) + 1);
  }
  return out;
}

/// The inverse of a symmetric positive semidefinite matrix, after scaling to a unit diagonal; a
/// direction that the data do not determine gets a huge variance, and leaves the others theirs.
MatrixXd scaled_inverse(const MatrixXd& normal) {
  const VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * normal * scale.asDiagonal());
  const VectorXd inverse = eigen.values.cwiseMax(1e-15).cwiseInverse();
  const MatrixXd& vectors = eigen.vectors;
  return scale.asDiagonal() * (vectors * inverse.asDiagonal() * vectors.transpose()) *
         scale.asDiagonal();
}

/// Fills the linear part and all covariances of `fit` at its poles.
///
///     cov(p) = (sum_c D_c^T P_c D_c)^-1,   cov(x_c) = (B_c^T B_c)^-1 + G_c cov(p) G_c^T,
///     G_c = B_c⁺ D_c,   cov(x_c, p) = -G_c cov(p)
void complete(const Model& model, SinusoidFit& fit, bool poles_vary) {
  const std::size_t num_channels = model.series().size();
  const std::size_t num_poles = fit.poles.size();
  const bool drift = model.options().fit_drift;
  const std::vector<Index> moving =
      poles_vary ? free_parameters(num_poles, model.options().fixed_decays) : std::vector<Index>{};
  const Index num_moving = static_cast<Index>(moving.size());
  MatrixXd normal = MatrixXd::Zero(num_moving, num_moving);
  std::vector<MatrixXd> gains(num_channels);

  fit.channels.assign(num_channels, {});
  fit.sum_of_squares = 0.0;
  fit.num_samples = 0;
  for (std::size_t c = 0; c < num_channels; ++c) {
    const ProjectedFit projected = model.project(c, fit.poles, num_moving > 0);
    const VectorXd& x = projected.coefficients;
    ChannelFit& channel = fit.channels[c];
    channel.offset = x(0);
    channel.drift_per_s = drift ? x(1) / duration_of(model.series()[c]) : 0.0;
    channel.cosine.resize(static_cast<Index>(num_poles));
    channel.sine.resize(static_cast<Index>(num_poles));
    for (std::size_t k = 0; k < num_poles; ++k) {
      channel.cosine(static_cast<Index>(k)) = x(column_of_pole(drift, k));
      channel.sine(static_cast<Index>(k)) = x(column_of_pole(drift, k) + 1);
    }
    if (model.keeps_residual(c)) channel.residual = model.residual(c, fit.poles, x);
    channel.sum_of_squares = model.sum_of_squares(c, projected, channel.residual);
    fit.sum_of_squares += projected.sum_of_squares;
    fit.num_samples += static_cast<int>(model.num_used(c));
    const MatrixXd& r = projected.triangle;
    const MatrixXd r_inverse =
        r.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(r.rows(), r.cols()));
    channel.covariance = r_inverse * r_inverse.transpose();
    channel.covariance_at_poles = channel.covariance;
    if (num_moving > 0) {
      normal += projected.normal(moving, moving);
      gains[c] = r_inverse * projected.inside(Eigen::all, moving);
    }
  }

  fit.pole_covariance =
      MatrixXd::Zero(2 * static_cast<Index>(num_poles), 2 * static_cast<Index>(num_poles));
  if (num_moving > 0) {
    const MatrixXd covariance = scaled_inverse(normal);
    fit.pole_covariance(moving, moving) = covariance;
    for (std::size_t c = 0; c < num_channels; ++c) {
      const MatrixXd shared = gains[c] * covariance;
      fit.channels[c].covariance += shared * gains[c].transpose();
      MatrixXd& with_poles = fit.channels[c].covariance_with_poles;
      with_poles = MatrixXd::Zero(shared.rows(), fit.pole_covariance.cols());
      with_poles(Eigen::all, moving) = -shared;
    }
  }
  for (std::size_t c = 0; drift && c < num_channels; ++c) {
    if (num_moving > 0)
      fit.channels[c].covariance_with_poles.row(1) /= duration_of(model.series()[c]);
    for (MatrixXd* covariance :
         {&fit.channels[c].covariance, &fit.channels[c].covariance_at_poles}) {
      covariance->row(1) /= duration_of(model.series()[c]);
      covariance->col(1) /= duration_of(model.series()[c]);
    }
  }
  fit.num_parameters = static_cast<int>(num_moving + static_cast<Index>(num_channels) *
                                                         column_of_pole(drift, num_poles));
}

void check_input(const std::vector<SampleSeries>& series,
                 std::size_t num_poles,
                 const RefineOptions& options) {
  options.check();
  if (series.empty()) throw InputError("refine_sinusoids: no series, expected at least one");
  for (const SampleSeries& s : series) {
    if (s.time_s.size() != s.value.size() || s.time_s.size() < 2) {
      throw InputError(
          fmt::format("series {}: {} times and {} values, expected as many and at least 2",
                      s.name,
                      s.time_s.size(),
                      s.value.size()));
    }
  }
  if (!options.weights.empty() && options.weights.size() != series.size()) {
    throw InputError(fmt::format("RefineOptions.weights has {} entries, expected {}",
                                 options.weights.size(),
                                 series.size()));
  }
  if (!options.records.empty() && options.records.size() != series.size()) {
    throw InputError(fmt::format("RefineOptions.records has {} entries, expected {}",
                                 options.records.size(),
                                 series.size()));
  }
  if (!options.fixed_decays.empty() && options.fixed_decays.size() != num_poles) {
    throw InputError(fmt::format("RefineOptions.fixed_decays has {} entries, expected {}",
                                 options.fixed_decays.size(),
                                 num_poles));
  }
}

/// Runs Ceres on the poles; returns why it stopped.
Termination minimize(const Model& model, std::vector<DampedPole>& poles) {
  std::vector<double> parameters;
  for (const DampedPole& pole : poles) {
    parameters.push_back(pole.frequency_hz);
    parameters.push_back(pole.decay_per_s);
  }
  double duration = 0.0;
  double density = 0.0;
  for (std::size_t c = 0; c < model.series().size(); ++c) {
    duration = std::max(duration, duration_of(model.series()[c]));
    density = std::max(
        density,
        static_cast<double>(model.series()[c].time_s.size()) / duration_of(model.series()[c]));
  }
  ceres::Problem problem;
  problem.AddResidualBlock(new ProjectedResidual(model, poles.size()), nullptr, parameters.data());
  const std::vector<bool>& fixed = model.options().fixed_decays;
  std::vector<int> constant;
  for (std::size_t k = 0; k < poles.size(); ++k) {
    const int f = static_cast<int>(2 * k);
    problem.SetParameterLowerBound(parameters.data(), f, 0.0);
    if (std::isfinite(model.options().max_frequency_hz)) {
      problem.SetParameterUpperBound(
          parameters.data(), f, std::max(model.options().max_frequency_hz, poles[k].frequency_hz));
    }
    if (!fixed.empty() && fixed[k]) {
      constant.push_back(f + 1);
      continue;
    }
    problem.SetParameterLowerBound(parameters.data(), f + 1, -kMaxGrowthExponent / duration);
    problem.SetParameterUpperBound(
        parameters.data(), f + 1, std::max(kMaxDecayPerSample * density, poles[k].decay_per_s));
  }
  if (!constant.empty()) {
    problem.SetManifold(parameters.data(),
                        new ceres::SubsetManifold(static_cast<int>(parameters.size()), constant));
  }
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  // Cubic interpolation at a bound fails on flat costs, and then prints.
  options.line_search_interpolation_type = ceres::BISECTION;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = model.options().max_iterations;
  options.parameter_tolerance = model.options().relative_step;
  options.function_tolerance = model.options().relative_step;
  options.gradient_tolerance = 0.0;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  poles = poles_from(parameters.data(), poles.size());
  if (summary.termination_type == ceres::CONVERGENCE) return Termination::Converged;
  if (summary.termination_type == ceres::NO_CONVERGENCE) return Termination::IterationLimit;
  return Termination::NumericalFailure;
}

}  // namespace

void RefineOptions::check() const {
  if (max_iterations < 1) {
    throw InputError(
        fmt::format("RefineOptions.max_iterations is {}, must be at least 1", max_iterations));
  }
  if (!(max_frequency_hz > 0.0)) {
    throw InputError(
        fmt::format("RefineOptions.max_frequency_hz is {}, must be > 0", max_frequency_hz));
  }
  if (!(relative_step > 0.0 && relative_step < 1.0)) {
    throw InputError(
        fmt::format("RefineOptions.relative_step is {}, must be within (0, 1)", relative_step));
  }
}

double SinusoidFit::variance() const {
  return sum_of_squares / std::max(num_samples - num_parameters, 1);
}

double SinusoidFit::amplitude(std::size_t c, std::size_t k) const {
  const Index i = static_cast<Index>(k);
  return std::hypot(channels[c].cosine(i), channels[c].sine(i));
}

SinusoidFit refine_sinusoids(const std::vector<SampleSeries>& series,
                             const std::vector<DampedPole>& start,
                             const RefineOptions& options) {
  check_input(series, start.size(), options);
  const Model model(series, options);
  SinusoidFit fit;
  fit.poles = start;
  fit.termination = start.empty() ? Termination::Converged : minimize(model, fit.poles);
  complete(model, fit, true);
  return fit;
}

SinusoidFit fit_amplitudes(const std::vector<SampleSeries>& series,
                           const std::vector<DampedPole>& poles,
                           const RefineOptions& options) {
  check_input(series, poles.size(), options);
  const Model model(series, options);
  SinusoidFit fit;
  fit.poles = poles;
  fit.termination = Termination::Converged;
  complete(model, fit, false);
  return fit;
}

}  // namespace twang
