// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/weighted_data.hpp"

#include "harmonic_inversion/mode_criteria.hpp"
#include "harmonic_inversion/robust_factors.hpp"

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Relative step at which a trial fit is good enough to be judged, of parameters and of the sum of
/// squares; the latter by this part of a sample's variance; and a final one.
constexpr double kTrialStep = 1e-5;
constexpr double kTrialSquares = 5e-3;
constexpr double kFinalStep = 1e-14;
constexpr int kTrialIterations = 20;
constexpr int kFinalIterations = 200;
/// Round-off of a sample, and of its phase per half turn of the fastest sinusoid up to then.
constexpr double kSampleRoundOff = 4e-15;
constexpr double kPhaseRoundOff = 2e-16;
/// A fit with a residual below this part of the signal is worth polishing before it is judged.
constexpr double kNearlyExact = 1e-4;

/// What an unknown position among n samples costs, in units of ln n, an unknown value costing one:
/// each is -2 ln of its share of what could be, a value known to 1 / sqrt(n) of its range.
constexpr double kPositionCost = 2.0;

/// Unknowns that it takes to set samples apart from the model: the value of each, and where each
/// run begins; those of a part of their weight for the other part.
double unknowns_of(const VectorXd& factors) {
  double out = 0.0;
  double most = 0.0;  // of the run
  for (Index i = 0; i < factors.size(); ++i) {
    const double lost = 1.0 - factors(i);
    out += lost + kPositionCost * std::max(lost - most, 0.0);
    most = lost > 0.0 ? std::max(most, lost) : 0.0;
  }
  return out;
}

/// All the same but for zeros.
bool has_even_weights(const VectorXd& weights) {
  const double weight = weights.maxCoeff();
  return (weights.array() == weight || weights.array() == 0.0).all();
}

}  // namespace

WeightedData::WeightedData(const std::vector<SampleSeries>& series, double step_s)
    : m_series(series), m_step_s(step_s) {
  for (const SampleSeries& s : series) {
    const double spread = std::sqrt((s.value.array() - s.value.mean()).square().mean());
    const double half_turns = s.time_s(s.time_s.size() - 1) / step_s;
    const double floor = (kSampleRoundOff + kPhaseRoundOff * half_turns) *
                         std::max(s.value.cwiseAbs().maxCoeff(), 1e-300);
    m_floor.push_back(floor);
    m_scatter.push_back({s.sigma.size() > 0 ? 1.0 : 0.0, std::max(spread, floor)});
    m_weights.push_back(
        m_scatter.back().variances(s.sigma, s.value.size()).cwiseSqrt().cwiseInverse());
    m_factors.push_back(VectorXd::Ones(s.value.size()));
    const auto record = EvenRecord::from(s, m_weights.back());
    m_records.push_back(record ? std::make_unique<EvenRecord>(*record) : nullptr);
  }
}

RefineOptions WeightedData::options_with_step(double relative_step, int max_iterations) const {
  RefineOptions out;
  out.fit_drift = fit_drift;
  for (const auto& record : m_records) out.records.push_back(record.get());
  if (std::find(m_records.begin(), m_records.end(), nullptr) != m_records.end())
    out.weights = m_weights;
  out.keep_residuals = false;
  out.relative_step = relative_step;
  out.max_iterations = max_iterations;
  out.max_frequency_hz = 0.5 / m_step_s;
  return out;
}

RefineOptions WeightedData::trial_options() const {
  double samples = 0.0;
  for (const SampleSeries& s : m_series) samples += static_cast<double>(s.value.size());
  return options_with_step(std::min(kTrialStep, kTrialSquares / samples), kTrialIterations);
}

RefineOptions WeightedData::final_options() const {
  return options_with_step(kFinalStep, kFinalIterations);
}

bool WeightedData::is_round_off(const SinusoidFit& fit) const {
  for (std::size_t c = 0; c < m_series.size(); ++c) {
    const auto n = static_cast<double>(m_series[c].value.size());
    if (std::sqrt(fit.channels[c].sum_of_squares) >= m_floor[c] * std::sqrt(n)) return false;
  }
  return true;
}

bool WeightedData::is_nearly_exact(const SinusoidFit& fit) const {
  for (std::size_t c = 0; c < m_series.size(); ++c) {
    const VectorXd& y = m_series[c].value;
    const double spread = (y.array() - y.mean()).matrix().norm();
    if (std::sqrt(fit.channels[c].sum_of_squares) > kNearlyExact * spread) return false;
  }
  return true;
}

VectorXd WeightedData::residual(const SinusoidFit& fit, std::size_t c) const {
  return residual(fit, fit.channels[c], c);
}

VectorXd WeightedData::residual(const SinusoidFit& fit,
                                const ChannelFit& channel,
                                std::size_t c) const {
  if (channel.residual.size() > 0) return channel.residual;
  const SampleSeries& s = m_series[c];
  VectorXd x(column_of_pole(true, fit.poles.size()));
  x(0) = channel.offset;
  x(1) = channel.drift_per_s * duration_of(s);
  for (std::size_t k = 0; k < fit.poles.size(); ++k) {
    const auto i = static_cast<Index>(k);
    x.segment<2>(column_of_pole(true, k)) << channel.cosine(i), channel.sine(i);
  }
  if (m_records[c] && EvenRecord::can_evaluate(fit.poles, duration_of(s)))
    return s.value - m_records[c]->evaluate_model(fit.poles, true, x);
  return s.value - evaluate_model(s, fit.poles, true, x);
}

VectorXd WeightedData::residual_of_own_fit(const SinusoidFit& fit, std::size_t c) const {
  const VectorXd joint = residual(fit, c);
  if (m_series.size() == 1 || fit.poles.empty()) return joint;
  RefineOptions options = final_options();  // exact data must come out so, each channel
  options.records = {m_records[c].get()};
  options.weights.clear();
  if (!m_records[c]) options.weights.push_back(m_weights[c]);
  const SinusoidFit own = refine_sinusoids({m_series[c]}, fit.poles, options);
  const VectorXd r = residual(own, own.channels.front(), c);
  return r.norm() < joint.norm() ? r : joint;
}

double WeightedData::moment_mismatch(const SinusoidFit& fit, std::size_t c) const {
  if (!m_records[c]) return 0.0;
  const ChannelFit& channel = fit.channels[c];
  const double squares = (m_weights[c].array() > 0.0).select(channel.residual, 0.0).squaredNorm();
  return std::abs(channel.sum_of_squares - squares) / std::max(squares, 1e-300);
}

std::vector<SampleSeries> WeightedData::weighted_residuals(const SinusoidFit& fit) const {
  std::vector<SampleSeries> out = m_series;
  const double scale = 1.0 / std::sqrt(std::max(fit.variance(), 1e-300));
  for (std::size_t c = 0; c < out.size(); ++c) {
    out[c].sigma.resize(0);
    if (has_even_weights(m_weights[c])) {
      out[c].value = scale * residual(fit, c).cwiseProduct(m_weights[c]);
    } else {
      const double unit = scale * m_weights[c].maxCoeff();
      out[c].value = unit * residual(fit, c);
      out[c].sigma = m_weights[c].maxCoeff() * m_weights[c].cwiseInverse();  // no weight: inf
    }
  }
  return out;
}

RefineOptions WeightedData::residual_options(const std::vector<SampleSeries>& residuals) const {
  RefineOptions out = trial_options();
  out.fit_drift = false;
  out.records.clear();
  out.weights.clear();
  const bool even = std::all_of(residuals.begin(), residuals.end(), [](const SampleSeries& s) {
    return s.sigma.size() == 0;
  });
  for (std::size_t c = 0; !even && c < residuals.size(); ++c) {
    const SampleSeries& s = residuals[c];
    out.weights.push_back(s.sigma.size() > 0 ? VectorXd(s.sigma.cwiseInverse())
                                             : VectorXd::Ones(s.value.size()));
  }
  return out;
}

double WeightedData::weigh(const SinusoidFit& fit) {
  m_num_outliers = 0;
  double change = 0.0;
  for (std::size_t c = 0; c < m_series.size(); ++c) {
    const VectorXd r = residual_of_own_fit(fit, c);
    VectorXd factors = find_factors(c, r);
    change = std::max(change, (factors - m_factors[c]).cwiseAbs().maxCoeff());
    m_factors[c] = std::move(factors);
    m_num_outliers += static_cast<int>((m_factors[c].array() == 0.0).count());
    m_scatter[c] = find_scatter(c, r, fit);
    m_weights[c] =
        m_factors[c].cwiseQuotient(m_scatter[c].variances(m_series[c].sigma, r.size()).cwiseSqrt());
    if (m_records[c] && !m_records[c]->set_weights(m_weights[c])) m_records[c] = nullptr;
  }
  return change;
}

SampleScatter WeightedData::find_scatter(std::size_t c,
                                         const VectorXd& r,
                                         const SinusoidFit& fit) const {
  const VectorXd& sigma = m_series[c].sigma;
  double freedom = std::max(m_factors[c].squaredNorm(), 1.0);
  // Without stated sigmas all weights of a channel are in proportion, whatever the freedom.
  if (sigma.size() > 0)
    freedom *=
        static_cast<double>(std::max(fit.num_samples - fit.num_parameters, 1)) / fit.num_samples;
  SampleScatter out = scatter_by_squares(r.cwiseProduct(m_factors[c]), sigma, freedom);
  const double least = sigma.size() > 0 ? out.factor * sigma.minCoeff() : 0.0;
  if (std::hypot(least, out.extra) < m_floor[c]) out.extra = m_floor[c];
  return out;
}

VectorXd WeightedData::find_factors(std::size_t c, const VectorXd& r) {
  // Round-off has outliers too, but they mean nothing.
  if (r.norm() < m_floor[c] * std::sqrt(static_cast<double>(r.size())))
    return VectorXd::Ones(r.size());
  const VectorXd& sigma = m_series[c].sigma;
  VectorXd z = r;
  if (sigma.size() > 0)
    z = r.cwiseQuotient(scatter_by_median(r, sigma).variances(sigma, r.size()).cwiseSqrt());
  VectorXd isolated = VectorXd::Ones(z.size());
  const std::vector<bool> is_isolated = find_isolated_outliers(z);
  for (Index i = 0; i < z.size(); ++i) {
    if (is_isolated[static_cast<std::size_t>(i)]) isolated(i) = 0.0;
  }
  VectorXd robust = robust_factors(z);
  if (!is_robust) {
    m_saw_runs_of_outliers |= (robust.array() < isolated.array()).any();
    return isolated;
  }
  // All or nothing in a long even record: the quick way knows no other weights.
  if (m_records[c]) robust = (robust.array() >= 0.5).cast<double>();
  return robust.cwiseMin(isolated);
}

double WeightedData::criterion(const SinusoidFit& fit) const {
  double out = 0.0;
  double samples = 0.0;
  double outliers = 0.0;
  for (std::size_t c = 0; c < m_series.size(); ++c) {
    const VectorXd r = residual(fit, c);
    const VectorXd variances = find_scatter(c, r, fit).variances(m_series[c].sigma, r.size());
    out += (r.cwiseProduct(m_factors[c]).array().square() / variances.array()).sum() +
           variances.array().log().sum();
    samples += static_cast<double>(r.size());
    outliers += unknowns_of(m_factors[c]);
  }
  return out + (fit.num_parameters + outliers) * std::log(samples);
}

std::vector<std::vector<bool>> WeightedData::outliers() const {
  std::vector<std::vector<bool>> out;
  for (const VectorXd& weights : m_weights) {
    out.emplace_back(static_cast<std::size_t>(weights.size()));
    for (Index i = 0; i < weights.size(); ++i) {
      out.back()[static_cast<std::size_t>(i)] = weights(i) == 0.0;
    }
  }
  return out;
}

std::vector<int> WeightedData::num_down_weighted() const {
  std::vector<int> out;
  for (const VectorXd& factors : m_factors) {
    out.push_back(static_cast<int>((factors.array() > 0.0 && factors.array() < 1.0).count()));
  }
  return out;
}

}  // namespace twang
