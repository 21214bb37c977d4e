// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/detail/followed_residuals.hpp"

#include "calibrate/detail/step_error.hpp"
#include "core/error.hpp"

#include <Eigen/QR>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace twang::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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
      m_origin_s(recording.inversion->time_origin_s),
      m_simulated(simulated) {}

const FollowedResiduals::Values* FollowedResiduals::values(const Parameters& p) {
  if (m_values && p == m_at) return &*m_values;
  std::optional<Values> found = simulate(p);
  if (!found) return nullptr;
  m_values = std::move(found);
  m_at = p;
  return &*m_values;
}

std::optional<MatrixXd> FollowedResiduals::derivatives(const Parameters& p) {
  const Values* here = values(p);
  if (here == nullptr) return {};
  // far below what a derivative changes over, far above the round-off of a simulation
  const Parameters steps(0.01, 0.02, 0.01, 0.01);
  constexpr double kHardlyMoved = 2.0;  // steps
  const bool kept = m_columns.size() != 0 &&
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
