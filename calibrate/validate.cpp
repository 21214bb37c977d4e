// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/validate.hpp"

#include "calibrate/simulated_observable.hpp"
#include "coarsen/prestress.hpp"
#include "core/units.hpp"
#include "fem/static_solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace twang {
namespace {

constexpr double kPeriodsCompared = 10.0;
// The trapezoidal rule lengthens a period by (omega h)²/12: 3.3e-4 at this many steps a period.
constexpr double kStepsPerPeriod = 100.0;

/// One sinusoid of the signal carried by a shape of the mesh.
struct CarriedMode {
  Eigen::VectorXd unit_shape;  ///< moves the observable by one
  double lambda_per_s2 = 0.0;  ///< of the mesh with E_n [1/s²]
  double displacement = 0.0;   ///< of the observable at the start [m] or [rad]
  double velocity = 0.0;       ///< [m/s] or [rad/s]
};

struct ValueAndRate {
  double value = 0.0;
  double rate = 0.0;
};

/// A sinusoid at its time origin, in the column's unit.
ValueAndRate at_origin(const DampedSinusoid& mode, std::size_t channel) {
  const SinusoidInChannel& in_channel = mode.channels[channel];
  const double omega = kTwoPi * mode.frequency_hz;
  return {in_channel.amplitude * std::sin(in_channel.phase_rad),
          in_channel.amplitude * (omega * std::cos(in_channel.phase_rad) -
                                  mode.decay_per_s * std::sin(in_channel.phase_rad))};
}

/// The strongest sinusoid on its eigenmode; each further one on the eigenmode of its
/// frequency, if there is one.
std::vector<CarriedMode> carry_modes(const MeshRung& coarse,
                                     const SimulatedObservable& observable,
                                     double modulus_pa,
                                     const InversionResult& inversion,
                                     double si_per_unit,
                                     int strongest) {
  constexpr double kSameFrequency = 0.15;  // relative: a coarse mesh shifts its overtones
  std::vector<CarriedMode> carried;
  std::vector<bool> taken(static_cast<std::size_t>(coarse.modes.count()), false);
  for (std::size_t k = 0; k < inversion.modes.size(); ++k) {
    const DampedSinusoid& mode = inversion.modes[k];
    std::optional<int> partner;
    double nearest = kSameFrequency;
    for (int i = 0; k > 0 && i < coarse.modes.count(); ++i) {
      const double frequency_hz = coarse.modes.natural_frequency_hz(i) * std::sqrt(modulus_pa);
      const double distance = std::abs(frequency_hz / mode.natural_frequency_hz() - 1.0);
      if (!taken[static_cast<std::size_t>(i)] && distance < nearest) {
        nearest = distance;
        partner = i;
      }
    }
    if (k == 0) partner = strongest;
    if (!partner) continue;
    const std::vector<int> cluster = mode_cluster(coarse.modes, *partner);
    Eigen::VectorXd shape = unit_observable_shape(coarse.modes, cluster, observable);
    if (shape.size() == 0) continue;
    for (const int index : cluster) taken[static_cast<std::size_t>(index)] = true;
    const ValueAndRate start = at_origin(mode, 0);
    carried.push_back({std::move(shape),
                       coarse.modes.lambda_per_s2[*partner] * modulus_pa,
                       start.value * si_per_unit,
                       start.rate * si_per_unit});
  }
  return carried;
}

/// What holds the body at rest, and where.
struct Rest {
  Eigen::VectorXd force;    ///< gravity; empty: none [N]
  Eigen::VectorXd u;        ///< sag [m]
  double observable = 0.0;  ///< there [m] or [rad]
};

/// Equilibrium under the inertia-like load sum lambda y M shape, which bends the body as its modes
/// do but lets it shorten as a real one; scaled until the observable is what was tracked.
StaticResult deflect(const ElasticBody& body,
                     const std::vector<int>& held_nodes,
                     const std::vector<CarriedMode>& carried,
                     const SimulatedObservable& observable,
                     const Rest& rest) {
  Eigen::VectorXd pluck = Eigen::VectorXd::Zero(body.mesh().num_dofs());
  double wanted = 0.0;
  for (const CarriedMode& mode : carried) {
    pluck += mode.lambda_per_s2 * mode.displacement * (body.mass() * mode.unit_shape);
    wanted += mode.displacement;
  }
  StaticLoad load;
  load.force = rest.force.size() == 0 ? pluck : pluck + rest.force;
  constexpr int kMostCorrections = 6;
  constexpr double kCloseEnough = 1e-6;
  StaticResult result = solve_static(body, held_nodes, load, {}, rest.u);
  for (int i = 0; i < kMostCorrections && result.usable(); ++i) {
    const double got = observable.evaluate(result.u) - rest.observable;
    if (std::abs(got - wanted) <= kCloseEnough * std::abs(wanted) || got * wanted <= 0.0) break;
    pluck *= wanted / got;
    load.force = rest.force.size() == 0 ? pluck : pluck + rest.force;
    result = solve_static(body, held_nodes, load, {}, result.u);
  }
  return result;
}

double interpolated(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto upper = std::upper_bound(x.begin(), x.end(), at);
  const auto i =
      std::clamp<std::ptrdiff_t>(upper - x.begin(), 1, static_cast<std::ptrdiff_t>(x.size()) - 1);
  const auto hi = static_cast<std::size_t>(i);
  const double weight = (at - x[hi - 1]) / (x[hi] - x[hi - 1]);
  return (1.0 - weight) * y[hi - 1] + weight * y[hi];
}

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
    validation.simulated.push_back(
        interpolated(validation.fine_time_s, validation.fine_simulated, time));
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
                                  int mode) {
  Validation validation;
  const DampedSinusoid& tracked = inversion.modes.front();
  const double si_per_unit = si_per_column_unit(column);
  validation.unit = column.substr(column.rfind('_') + 1);

  const ElasticMaterial elastic = {material.youngs_modulus_numerical_pa,
                                   material.poissons_ratio,
                                   material.density_kg_m3,
                                   material.damping_stiffness_b_s,
                                   material.damping_mass_a_per_s};
  ElasticBody body(coarse.mesh,
                   std::vector<ElasticMaterial>(coarse.mesh.material_names.size(), elastic));
  for (const PointMass& mass : rig.masses)
    body.add_point_mass(locate(coarse.mesh, mass.at), mass.mass_kg);
  const SimulatedObservable observable(rig, coarse, mode);
  const std::vector<CarriedMode> carried =
      carry_modes(coarse, observable, elastic.youngs_modulus_pa, inversion, si_per_unit, mode);
  if (carried.empty()) {
    validation.run.termination = Termination::NumericalFailure;
    validation.run.message = fmt::format(
        "Eigenmode {} of the mesh does not move the observable; the trace cannot be simulated.",
        mode + 1);
    return validation;
  }
  Rest rest;
  if (rig.gravity_m_s2) {
    rest.force = body.gravity_force(*rig.gravity_m_s2);
    rest.u = sag_under_gravity(rig, coarse, elastic).u;
    rest.observable = observable.evaluate(rest.u);
  }
  const StaticResult start = deflect(body, coarse.held_nodes, carried, observable, rest);
  if (!start.usable()) {
    validation.run.termination = Termination::NumericalFailure;
    validation.run.message = fmt::format(
        "The tracked initial deflection cannot be reached by the coarse mesh: {}", start.message);
    return validation;
  }
  BodyState state;
  state.u = start.u;
  state.v = Eigen::VectorXd::Zero(start.u.size());
  for (const CarriedMode& one : carried) state.v += one.velocity * one.unit_shape;

  const double period_s = 1.0 / tracked.frequency_hz;
  const double end_s =
      std::min(inversion.time_end_s, inversion.time_origin_s + kPeriodsCompared * period_s);
  // A heavily damped part is stiff: where a step fails, all is done again with shorter ones.
  constexpr int kAttempts = 3;
  constexpr double kShorter = 4.0;
  validation.step_s = period_s / kStepsPerPeriod;
  for (int attempt = 0; attempt < kAttempts && !validation.run.usable(); ++attempt) {
    if (attempt > 0) validation.step_s /= kShorter;
    validation.fine_time_s.clear();
    validation.fine_simulated.clear();
    NewmarkOptions options;
    options.step_s = validation.step_s;
    NewmarkIntegrator integrator(body, coarse.held_nodes, options, rest.force);
    BodyState now = state;
    validation.run = run(
        integrator,
        now,
        options.step_s,
        end_s - inversion.time_origin_s + options.step_s,
        [&](const BodyState& at) {
          validation.fine_time_s.push_back(inversion.time_origin_s + at.time_s);
          validation.fine_simulated.push_back((observable.evaluate(at.u) - rest.observable) /
                                              si_per_unit);
        },
        progress);
  }
  if (!validation.run.usable()) return validation;
  compare_with_samples(validation, trace, *trace.find(column), inversion, end_s);
  measure_simulated(validation, tracked);
  return validation;
}

}  // namespace twang
