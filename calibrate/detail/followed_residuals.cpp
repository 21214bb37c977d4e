// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/detail/followed_residuals.hpp"

#include "calibrate/detail/step_error.hpp"

#include <Eigen/QR>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace twang::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of a sample, 1 over the standard deviation with which the inversion weighed it.
double weight_of(const Channel* sigma, const InversionResult& inversion, std::size_t i) {
  if (sigma == nullptr) return 1.0;
  const double stated = sigma->values[i];
  if (inversion.weights.empty() || !(inversion.weights.front().sigma_factor > 0.0))
    return 1.0 / stated;
  const ChannelWeights& used = inversion.weights.front();
  return 1.0 / std::hypot(used.sigma_factor * stated, used.extra_sigma);
}

/// Orthonormal columns: what an offset, and perhaps a drift, adds to the weighed samples.
MatrixXd rest_of(const Samples& samples, bool drifts, double origin_s) {
  MatrixXd rest = samples.weight;
  if (drifts) {
    rest.conservativeResize(Eigen::NoChange, 2);
    rest.col(1) = samples.weight.cwiseProduct((samples.time_s.array() - origin_s).matrix());
  }
  return rest.householderQr().householderQ() * MatrixXd::Identity(rest.rows(), rest.cols());
}

std::string too_little(const Samples& samples, const std::string& column, double seen) {
  constexpr Index kFewestSamples = 8;
  if (seen < 1.0)
    return fmt::format("{:.2f} of a period of {} lie in the window after what is left to settle",
                       std::max(seen, 0.0),
                       column);
  if (samples.value.size() < kFewestSamples)
    return fmt::format(
        "{} samples of {} lie in its first {:.3g} periods", samples.value.size(), column, seen);
  return {};
}

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
    const double weight = weight_of(sigma, inversion, i);
    if (!(time >= begin_s && time <= samples.end_s) || !std::isfinite(channel.values[i]) ||
        !std::isfinite(weight))
      continue;
    rows.push_back({time, channel.values[i], weight});
  }
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
  samples.fault = too_little(samples, recording.column, (samples.end_s - begin_s) * frequency_hz);
  if (samples.fault.empty())
    samples.rest = rest_of(samples, inversion.drifts_per_s[0] != 0.0, origin_s);
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

/// Far below what a derivative changes over, far above the round-off of a simulation.
Parameters difference_steps() { return {0.01, 0.02, 0.01, 0.01}; }

}  // namespace

MatrixXd weighed(const MatrixXd& rows, const Samples& samples) {
  const MatrixXd all = samples.weight.asDiagonal() * rows;
  return all - samples.rest * (samples.rest.transpose() * all);
}

FollowedResiduals::FollowedResiduals(const Rig& rig,
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
      m_drifts(recording.inversion->drifts_per_s[0] != 0.0),
      m_origin_s(recording.inversion->time_origin_s),
      m_simulated(simulated) {}

const FollowedResiduals::Values* FollowedResiduals::values(const Parameters& p) {
  if (m_values && p == m_at) return &*m_values;
  if (std::abs(p[0]) > std::log(kFarthestModulus) ||
      std::abs(p[1] - 0.5 * p[0]) > std::log(kFarthestDamping)) {
    m_message = fmt::format(
        "it would have to move E_n by more than a factor of {} or b by one of {}, farther than a "
        "large motion leads a linear estimate astray",
        kFarthestModulus,
        kFarthestDamping);
    return nullptr;
  }
  std::optional<Values> found = simulate(p);
  if (!found) return nullptr;
  m_values = std::move(found);
  m_at = p;
  return &*m_values;
}

std::optional<MatrixXd> FollowedResiduals::derivatives(const Parameters& p) {
  if (values(p) == nullptr) return {};
  constexpr double kFar =
      5.0;  // steps of the differences: Broyden's updates do not follow that far
  if (m_columns.size() == 0 ||
      (p - m_differenced_at).cwiseQuotient(difference_steps()).cwiseAbs().maxCoeff() > kFar) {
    if (!difference(p)) return {};
  } else if (p != m_columns_at) {
    update(p);
  }
  MatrixXd all = m_columns;
  if (m_dilates) all.col(0) = dilation();
  return all;
}

VectorXd FollowedResiduals::dilation() const {
  return 0.5 * (m_samples.time_s.array() - m_origin_s) * m_values->slope.array();
}

bool FollowedResiduals::difference(const Parameters& p) {
  const Parameters steps = difference_steps();
  const Values base = *m_values;
  MatrixXd columns = MatrixXd::Zero(m_samples.value.size(), kNumParameters);
  for (Index k = m_dilates ? 1 : 0; k < kNumParameters; ++k) {
    Parameters moved = p;
    moved[k] += steps[k];
    const std::optional<Values> there = simulate(moved);
    if (!there) return false;
    columns.col(k) = (there->simulated - base.simulated) / steps[k];
  }
  m_columns = std::move(columns);
  m_columns_at = p;
  m_differenced_at = p;
  m_simulated_there = base.simulated;
  return true;
}

void FollowedResiduals::update(const Parameters& p) {
  Parameters step = p - m_columns_at;
  VectorXd missed = m_values->simulated - m_simulated_there;
  if (m_dilates) {
    missed -= step[0] * dilation();
    step[0] = 0.0;
  }
  missed -= m_columns * step;
  // of a step that is hardly one the rest is the simulation's round-off
  constexpr double kLeast = 1e-5;
  if (step.norm() > kLeast) m_columns += missed * step.transpose() / step.squaredNorm();
  m_columns_at = p;
  m_simulated_there = m_values->simulated;
}

int FollowedResiduals::leave_out_outliers(const Parameters& p) {
  constexpr double kFarOff = 6.0;  // robust standard deviations
  constexpr int kOneIn = 10;       // at most: more are not outliers but a motion not understood
  constexpr double kNormalOverMedian = 1.4826;
  const Values* here = values(p);
  if (here == nullptr) return 0;
  const VectorXd off = weighed(m_samples.value - here->simulated, m_samples).cwiseAbs();
  std::vector<double> sorted(off.data(), off.data() + off.size());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const auto far = (off.array() > kFarOff * kNormalOverMedian * *middle).eval();
  const auto count = static_cast<int>(far.count());
  if (count == 0 || count * kOneIn > static_cast<int>(off.size())) return 0;
  m_samples.weight = far.select(VectorXd::Zero(off.size()), m_samples.weight);
  m_samples.rest = rest_of(m_samples, m_drifts, m_origin_s);
  return count;
}

std::optional<FollowedResiduals::Values> FollowedResiduals::simulate(const Parameters& p) {
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

}  // namespace twang::detail
