// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/validate.hpp"

#include "calibrate/strongest_sinusoid.hpp"
#include "harmonic_inversion/evaluate_modes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

constexpr double kPeriodsCompared = 10.0;
// The trapezoidal rule lengthens a period by (omega h)²/12: 3.3e-4 at this many steps a period.
constexpr double kStepsPerPeriod = 100.0;

/// f and d of both motions by the same fit at the same times: of a large motion, which they change
/// in, any other would be another average. The tracked one is what its sinusoids say there.
void compare_sinusoids(Validation& validation, const InversionResult& inversion) {
  SampleSeries samples;
  samples.time_s = Eigen::Map<const Eigen::VectorXd>(
      validation.time_s.data(), static_cast<Eigen::Index>(validation.time_s.size()));
  samples.time_s.array() -= inversion.origin_s(0);
  const auto strongest = [&] {
    return fit_strongest_sinusoid(samples, inversion.modes).value_or(DampedPole{kNaN, kNaN});
  };
  samples.value = evaluate_modes(inversion, 0, samples.time_s) -
                  inversion.drifts_per_s.front() * samples.time_s;
  validation.tracked_sinusoid = strongest();
  samples.value =
      Eigen::Map<const Eigen::VectorXd>(validation.simulated.data(), samples.time_s.size());
  validation.simulated_sinusoid = strongest();
  const DampedPole& tracked = validation.tracked_sinusoid;
  const DampedPole& simulated = validation.simulated_sinusoid;
  validation.figures.frequency_error_rel = simulated.frequency_hz / tracked.frequency_hz - 1.0;
  validation.figures.decay_error_rel = simulated.decay_per_s / tracked.decay_per_s - 1.0;
}

void compare_with_samples(Validation& validation,
                          const FollowedMotion& motion,
                          const Trace& trace,
                          const Channel& channel,
                          const InversionResult& inversion,
                          double end_s) {
  double square_sum = 0.0;
  const Channel* offset_s = trace.time_offset_of(channel.name);
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    const double time = trace.time_s[i] + (offset_s == nullptr ? 0.0 : offset_s->values[i]);
    if (!(time >= inversion.time_origin_s && time <= end_s) || !std::isfinite(channel.values[i]))
      continue;
    const double rest =
        inversion.offsets[0] + inversion.drifts_per_s[0] * (time - inversion.time_origin_s);
    validation.time_s.push_back(time);
    validation.tracked.push_back(channel.values[i] - rest);
    validation.simulated.push_back(motion.at(time));
    square_sum += std::pow(validation.simulated.back() - validation.tracked.back(), 2);
  }
  const double amplitude = inversion.modes.front().channels.front().amplitude;
  validation.figures.rms_rel =
      std::sqrt(square_sum / static_cast<double>(validation.time_s.size())) / amplitude;
}

}  // namespace

Validation validate_against_trace(const Rig& rig,
                                  const MeshRung& coarse,
                                  const Material& material,
                                  const Trace& trace,
                                  const std::string& column,
                                  const InversionResult& inversion,
                                  const ProgressCallback& progress,
                                  int mode,
                                  const MeshObserver& on_state,
                                  const FollowedStart& start) {
  Validation validation;
  const DampedSinusoid& tracked = inversion.modes.front();
  validation.unit = column.substr(column.rfind('_') + 1);
  const ElasticMaterial elastic = {material.youngs_modulus_numerical_pa,
                                   material.poissons_ratio,
                                   material.density_kg_m3,
                                   material.damping_stiffness_b_s,
                                   material.damping_mass_a_per_s};
  const double end_s = std::min(inversion.time_end_s,
                                inversion.time_origin_s + kPeriodsCompared / tracked.frequency_hz);
  const TraceFollower follower(rig, coarse, inversion, column, mode);
  const auto watch = [&](const BodyState& state) {
    on_state(coarse.mesh, inversion.time_origin_s + state.time_s, state.u);
  };
  FollowedMotion motion =
      follower.follow(elastic,
                      start,
                      end_s,
                      kStepsPerPeriod,
                      progress,
                      on_state ? watch : std::function<void(const BodyState&)>());
  validation.run = motion.run;
  validation.step_s = motion.step_s;
  if (!validation.run.usable()) return validation;
  compare_with_samples(validation, motion, trace, *trace.find(column), inversion, end_s);
  validation.fine_time_s = std::move(motion.time_s);
  validation.fine_simulated = std::move(motion.observable);
  compare_sinusoids(validation, inversion);
  return validation;
}

}  // namespace twang
