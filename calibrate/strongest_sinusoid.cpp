// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/strongest_sinusoid.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/refine_sinusoids.hpp"

#include <Eigen/Core>

#include <cmath>

namespace twang {
namespace {

DampedPole pole_of(const DampedSinusoid& mode) { return {mode.frequency_hz, mode.decay_per_s}; }

/// What the poles but the first add to the samples, offset included.
Eigen::VectorXd beside_the_first(const SampleSeries& samples,
                                 const std::vector<DampedPole>& poles) {
  const ChannelFit fit = fit_amplitudes({samples}, poles).channels.front();
  Eigen::VectorXd sum = Eigen::VectorXd::Constant(samples.value.size(), fit.offset);
  for (std::size_t k = 1; k < poles.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    const Eigen::ArrayXd phase = kTwoPi * poles[k].frequency_hz * samples.time_s.array();
    const Eigen::ArrayXd envelope = (-poles[k].decay_per_s * samples.time_s.array()).exp();
    sum.array() += envelope * (fit.cosine[at] * phase.cos() + fit.sine[at] * phase.sin());
  }
  return sum;
}

}  // namespace

std::optional<DampedPole> fit_strongest_sinusoid(const SampleSeries& samples,
                                                 const std::vector<DampedSinusoid>& known) {
  constexpr double kCompanion = 0.1;  // of the strongest frequency
  std::vector<DampedPole> poles;
  for (const DampedSinusoid& mode : known) {
    const double ratio = mode.frequency_hz / known.front().frequency_hz;
    if (poles.empty() || std::abs(ratio - 1.0) >= kCompanion) poles.push_back(pole_of(mode));
  }
  const auto num_unknown = static_cast<Eigen::Index>(2 * poles.size() + 3);
  if (poles.empty() || samples.value.size() < 2 * num_unknown) return {};
  // The others hardly depend on the strongest: a few rounds by turns find all together.
  constexpr int kMostRounds = 20;
  constexpr double kSettled = 1e-7;
  for (int round = 0; round < kMostRounds; ++round) {
    SampleSeries alone = samples;
    if (poles.size() > 1) alone.value -= beside_the_first(samples, poles);
    const SinusoidFit fit = refine_sinusoids({alone}, {poles.front()});
    if (fit.termination != Termination::Converged) return {};
    const DampedPole before = poles.front();
    poles.front() = fit.poles.front();
    const double moved = std::hypot(kTwoPi * (poles.front().frequency_hz - before.frequency_hz),
                                    poles.front().decay_per_s - before.decay_per_s);
    if (poles.size() == 1 || moved < kSettled * kTwoPi * before.frequency_hz) return poles.front();
  }
  return {};
}

}  // namespace twang
