// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/inversion_draws.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/cramer_rao.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/refine_sinusoids.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace twang::bench {
namespace {

/// A mode counts as found this close to the true frequency.
constexpr double kFoundWithin = 0.05;

SinusoidTruth sinusoid(double frequency_hz, double damping_ratio, double phase_rad) {
  const double decay =
      kTwoPi * frequency_hz * damping_ratio / std::sqrt(1.0 - damping_ratio * damping_ratio);
  return {frequency_hz, decay, 1.0, phase_rad};
}

double random_phase(std::uint32_t seed) {
  std::mt19937 generator(seed + 500000U);  // not the stream of the noise
  return std::uniform_real_distribution<double>(-kPi, kPi)(generator);
}

void add(double error, double sigma, double bound, Spread& spread) {
  spread.rmse_over_bound += std::pow(error / bound, 2);
  spread.within_one += std::abs(error) < sigma ? 1.0 : 0.0;
  spread.within_two += std::abs(error) < 2.0 * sigma ? 1.0 : 0.0;
}

void close(int count, Spread& spread) {
  const double n = std::max(count, 1);
  spread.rmse_over_bound = std::sqrt(spread.rmse_over_bound / n);
  spread.within_one /= n;
  spread.within_two /= n;
}

/// Where least squares ends that starts at the truth.
DampedPole fit_from_truth(const Trace& trace, const SinusoidTruth& truth) {
  const std::vector<double>& time_s = trace.time_s;
  const std::vector<double>& value = trace.channels.front().values;
  SampleSeries series;
  series.time_s = Eigen::VectorXd::Map(time_s.data(), static_cast<Eigen::Index>(time_s.size()));
  series.value = Eigen::VectorXd::Map(value.data(), static_cast<Eigen::Index>(value.size()));
  return refine_sinusoids({series}, {{truth.frequency_hz, truth.decay_per_s}}).poles.front();
}

}  // namespace

DrawStatistics draw_sinusoids(const DrawnSinusoid& truth, int draws, std::uint32_t first_seed) {
  DrawStatistics out;
  out.draws = draws;
  SynthesisOptions options;
  options.noise_sigma = std::pow(10.0, -truth.snr_db / 20.0);
  for (int draw = 0; draw < draws; ++draw) {
    options.seed = first_seed + static_cast<std::uint32_t>(draw);
    const SinusoidTruth s =
        sinusoid(truth.frequency_hz, truth.damping_ratio, random_phase(options.seed));
    const CramerRaoBound bound = cramer_rao_bounds({s}, options).front();
    const Trace trace = synthesize_sinusoids({s}, options);
    const DampedPole best = fit_from_truth(trace, s);
    out.best_frequency += std::pow((best.frequency_hz - s.frequency_hz) / bound.frequency_hz, 2);
    out.best_decay += std::pow((best.decay_per_s - s.decay_per_s) / bound.decay_per_s, 2);
    const InversionResult result = invert_harmonics(trace, {"y"});
    if (!result.usable()) {
      ++out.missed;
      continue;
    }
    out.extra += static_cast<int>(result.modes.size()) - 1;
    const DampedSinusoid& mode = result.modes.front();
    add(mode.frequency_hz - s.frequency_hz,
        mode.frequency_sigma_hz,
        bound.frequency_hz,
        out.frequency);
    add(mode.decay_per_s - s.decay_per_s, mode.decay_sigma_per_s, bound.decay_per_s, out.decay);
  }
  close(draws - out.missed, out.frequency);
  close(draws - out.missed, out.decay);
  out.best_frequency = std::sqrt(out.best_frequency / draws);
  out.best_decay = std::sqrt(out.best_decay / draws);
  return out;
}

int count_false_alarms(int draws, std::uint32_t first_seed) {
  int alarms = 0;
  SynthesisOptions options;
  options.noise_sigma = 1.0;
  for (int draw = 0; draw < draws; ++draw) {
    options.seed = first_seed + static_cast<std::uint32_t>(draw);
    alarms += invert_harmonics(synthesize_sinusoids({}, options), {"y"}).usable() ? 1 : 0;
  }
  return alarms;
}

int count_detections(int draws, std::uint32_t first_seed) {
  int found = 0;
  SynthesisOptions options;
  options.noise_sigma = 1.0 / 20.0;
  for (int draw = 0; draw < draws; ++draw) {
    options.seed = first_seed + static_cast<std::uint32_t>(draw);
    const SinusoidTruth s = sinusoid(20.0, 0.05, random_phase(options.seed));
    const InversionResult result = invert_harmonics(synthesize_sinusoids({s}, options), {"y"});
    found += std::any_of(result.modes.begin(),
                         result.modes.end(),
                         [&](const DampedSinusoid& mode) {
                           return std::abs(mode.frequency_hz - s.frequency_hz) <
                                  kFoundWithin * s.frequency_hz;
                         })
                 ? 1
                 : 0;
  }
  return found;
}

}  // namespace twang::bench
