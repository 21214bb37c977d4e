// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/validate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

constexpr double kPeriodsCompared = 10.0;
// The trapezoidal rule lengthens a period by (omega h)²/12: 3.3e-4 at this many steps a period.
constexpr double kStepsPerPeriod = 100.0;

/// f and d of the simulated observable, by the same inversion as the tracked one.
void measure_simulated(Validation& validation, const DampedSinusoid& tracked) {
  constexpr std::size_t kEveryNth = 5;  // 20 samples a period are plenty
  Trace trace;
  Channel channel{"simulated", {}};
  for (std::size_t i = 0; i < validation.fine_time_s.size(); i += kEveryNth) {
    trace.time_s.push_back(validation.fine_time_s[i]);
    channel.values.push_back(validation.fine_simulated[i]);
  }
  trace.channels.push_back(std::move(channel));
  constexpr std::size_t kFewestSamples = 16;
  if (trace.num_samples() < kFewestSamples) return;
  InversionOptions options;
  options.start_s = trace.time_s.front();
  options.end_s = trace.time_s.back();
  const InversionResult result = invert_harmonics(trace, {"simulated"}, options);
  if (!result.usable()) return;
  // What is far weaker than the strongest is a trace of the fit's, wherever its frequency lies.
  constexpr double kWeakest = 0.1;
  const double strongest = result.modes.front().channels.front().amplitude;
  const DampedSinusoid* nearest = &result.modes.front();
  for (const DampedSinusoid& mode : result.modes) {
    if (mode.channels.front().amplitude < kWeakest * strongest) continue;
    if (std::abs(mode.frequency_hz - tracked.frequency_hz) <
        std::abs(nearest->frequency_hz - tracked.frequency_hz))
      nearest = &mode;
  }
  validation.simulated_frequency_hz = nearest->frequency_hz;
  validation.simulated_decay_per_s = nearest->decay_per_s;
  validation.figures.frequency_error_rel = nearest->frequency_hz / tracked.frequency_hz - 1.0;
  validation.figures.decay_error_rel = nearest->decay_per_s / tracked.decay_per_s - 1.0;
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
  measure_simulated(validation, tracked);
  return validation;
}

}  // namespace twang
