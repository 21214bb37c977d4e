// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/trace_follower.hpp"

#include "coarsen/prestress.hpp"
#include "core/constants.hpp"
#include "fem/attach_weights.hpp"
#include "fem/static_solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace twang {
namespace {

/// One sinusoid of the signal carried by a shape of the mesh.
struct CarriedMode {
  Eigen::VectorXd unit_shape;  ///< moves the observable by one
  double lambda_per_s2 = 0.0;  ///< of the mesh with its material [1/s²]
  double displacement = 0.0;   ///< of the observable at the start [m] or [rad]
  double velocity = 0.0;       ///< [m/s] or [rad/s]
};

/// A sinusoid at its time origin, turned in phase: value and rate, in the column's unit.
std::pair<double, double> at_origin(const DampedSinusoid& mode, double turn_rad) {
  const SinusoidInChannel& in_channel = mode.channels.front();
  const double omega = kTwoPi * mode.frequency_hz;
  const double phase_rad = in_channel.phase_rad + turn_rad;
  return {in_channel.amplitude * std::sin(phase_rad),
          in_channel.amplitude *
              (omega * std::cos(phase_rad) - mode.decay_per_s * std::sin(phase_rad))};
}

/// The eigenmode not yet taken whose frequency is that of a sinusoid.
std::optional<int> partner_of(const DampedSinusoid& sinusoid,
                              const Eigenmodes& modes,
                              double modulus_pa,
                              const std::vector<bool>& taken) {
  constexpr double kSameFrequency = 0.15;  // relative: a coarse mesh shifts its overtones
  std::optional<int> partner;
  double nearest = kSameFrequency;
  for (int i = 0; i < modes.count(); ++i) {
    const double frequency_hz = modes.natural_frequency_hz(i) * std::sqrt(modulus_pa);
    const double distance = std::abs(frequency_hz / sinusoid.natural_frequency_hz() - 1.0);
    if (!taken[static_cast<std::size_t>(i)] && distance < nearest) {
      nearest = distance;
      partner = i;
    }
  }
  return partner;
}

/// Whether a sinusoid is the second or third harmonic that a large motion of the strongest one has:
/// no mode of its own.
bool is_harmonic(const DampedSinusoid& sinusoid, const DampedSinusoid& strongest) {
  constexpr double kNear = 0.02;  // of frequency
  const double ratio = sinusoid.frequency_hz / strongest.frequency_hz;
  return std::abs(ratio - 2.0) < 2.0 * kNear || std::abs(ratio - 3.0) < 3.0 * kNear;
}

/// Whether a sinusoid that no other mode of the mesh has stands beside the strongest one: a large
/// motion, whose frequency and decay change as its amplitude falls, is fitted by two of nearly one
/// frequency.
bool is_companion(const DampedSinusoid& sinusoid, const DampedSinusoid& strongest) {
  constexpr double kNear = 0.1;  // of frequency
  return std::abs(sinusoid.frequency_hz / strongest.frequency_hz - 1.0) < kNear;
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
                     const Rest& rest,
                     double later_s,
                     const Eigen::VectorXd& guess) {
  Eigen::VectorXd pluck = Eigen::VectorXd::Zero(body.mesh().num_dofs());
  double wanted = 0.0;
  for (const CarriedMode& mode : carried) {
    const double y = mode.displacement + later_s * mode.velocity;
    pluck += mode.lambda_per_s2 * y * (body.mass() * mode.unit_shape);
    wanted += y;
  }
  StaticLoad load;
  load.force = rest.force.size() == 0 ? pluck : pluck + rest.force;
  constexpr int kMostCorrections = 6;
  constexpr double kCloseEnough = 1e-7;
  StaticResult result = solve_static(body, held_nodes, load, {}, guess);
  for (int i = 0; i < kMostCorrections && result.usable(); ++i) {
    const double got = observable.evaluate(result.u) - rest.observable;
    if (std::abs(got - wanted) <= kCloseEnough * std::abs(wanted) || got * wanted <= 0.0) break;
    pluck *= wanted / got;
    load.force = rest.force.size() == 0 ? pluck : pluck + rest.force;
    result = solve_static(body, held_nodes, load, {}, result.u);
  }
  return result;
}

}  // namespace

double FollowedMotion::at(double wanted_s) const {
  const auto upper = std::upper_bound(time_s.begin(), time_s.end(), wanted_s);
  const auto i = std::clamp<std::ptrdiff_t>(
      upper - time_s.begin(), 1, static_cast<std::ptrdiff_t>(time_s.size()) - 1);
  const auto hi = static_cast<std::size_t>(i);
  const double weight = (wanted_s - time_s[hi - 1]) / (time_s[hi] - time_s[hi - 1]);
  return (1.0 - weight) * observable[hi - 1] + weight * observable[hi];
}

TraceFollower::TraceFollower(const Rig& rig,
                             const MeshRung& rung,
                             const InversionResult& inversion,
                             const std::string& column,
                             int mode)
    : m_rig(&rig),
      m_rung(&rung),
      m_inversion(&inversion),
      m_mode(mode),
      m_si_per_unit(si_per_column_unit(column)),
      m_observable(rig, rung, mode) {}

FollowedMotion TraceFollower::follow(const ElasticMaterial& material,
                                     const FollowedStart& start,
                                     double end_s,
                                     double steps_per_period,
                                     const ProgressCallback& progress,
                                     const std::function<void(const BodyState&)>& on_state) const {
  FollowedMotion motion;
  const auto fail = [&](std::string message) {
    motion.run.termination = Termination::NumericalFailure;
    motion.run.message = std::move(message);
    return motion;
  };
  const Eigenmodes& modes = m_rung->modes;
  std::vector<CarriedMode> carried;
  std::vector<bool> taken(static_cast<std::size_t>(modes.count()), false);
  for (std::size_t k = 0; k < m_inversion->modes.size(); ++k) {
    const DampedSinusoid& sinusoid = m_inversion->modes[k];
    const auto [value, rate] = at_origin(sinusoid, k == 0 ? start.turn_rad : 0.0);
    const std::optional<int> partner =
        k == 0 ? std::optional<int>(m_mode)
               : partner_of(sinusoid, modes, material.youngs_modulus_pa, taken);
    const DampedSinusoid& strongest = m_inversion->modes.front();
    if (k > 0 && !carried.empty() &&
        (is_harmonic(sinusoid, strongest) || (!partner && is_companion(sinusoid, strongest)))) {
      carried.front().displacement += value * m_si_per_unit;
      carried.front().velocity += rate * m_si_per_unit * start.velocity;
      continue;
    }
    if (!partner) continue;
    const std::vector<int> cluster = mode_cluster(modes, *partner);
    Eigen::VectorXd shape = unit_observable_shape(modes, cluster, m_observable);
    if (shape.size() == 0) continue;
    for (const int index : cluster) taken[static_cast<std::size_t>(index)] = true;
    const double scale = m_si_per_unit * (k == 0 ? start.amplitude : 1.0);
    carried.push_back({std::move(shape),
                       modes.lambda_per_s2[*partner] * material.youngs_modulus_pa,
                       value * scale,
                       rate * scale * start.velocity});
  }
  if (carried.empty())
    return fail(fmt::format(
        "Eigenmode {} of the mesh does not move the observable; the trace cannot be simulated.",
        m_mode + 1));

  ElasticBody body(m_rung->mesh,
                   std::vector<ElasticMaterial>(m_rung->mesh.material_names.size(), material));
  attach_weights(body, m_rig->masses);
  Rest rest;
  if (m_rig->gravity_m_s2) {
    rest.force = body.gravity_force(*m_rig->gravity_m_s2);
    rest.u = sag_under_gravity(*m_rig, *m_rung, material).u;
    rest.observable = m_observable.evaluate(rest.u);
  }
  // The velocity is the change of the deflected shape over a time in which it changes little.
  constexpr double kPartOfPeriod = 1e-3;
  const double period_s = 1.0 / m_inversion->modes.front().frequency_hz;
  const double later_s = kPartOfPeriod * period_s;
  const StaticResult now =
      deflect(body, m_rung->held_nodes, carried, m_observable, rest, 0.0, rest.u);
  StaticResult later = now;
  if (now.usable())
    later = deflect(body, m_rung->held_nodes, carried, m_observable, rest, later_s, now.u);
  for (const StaticResult* result : {&now, static_cast<const StaticResult*>(&later)}) {
    if (result->usable()) continue;
    return fail(
        fmt::format("The tracked initial deflection cannot be reached by the coarse mesh: {}",
                    result->message));
  }
  BodyState state;
  state.u = now.u;
  state.v = (later.u - now.u) / later_s;
  for (const int node : m_rung->held_nodes) state.v.segment<3>(3 * node).setZero();

  // A heavily damped part is stiff: where a step fails, all is done again with shorter ones.
  constexpr int kAttempts = 3;
  constexpr double kShorter = 4.0;
  const double origin_s = m_inversion->time_origin_s;
  motion.step_s = period_s / steps_per_period;
  for (int attempt = 0; attempt < kAttempts && !motion.run.usable(); ++attempt) {
    if (attempt > 0) motion.step_s /= kShorter;
    motion.time_s.clear();
    motion.observable.clear();
    NewmarkOptions options;
    options.step_s = motion.step_s;
    NewmarkIntegrator integrator(body, m_rung->held_nodes, options, rest.force);
    BodyState moving = state;
    const auto observe = [&](const BodyState& at) {
      motion.time_s.push_back(origin_s + at.time_s);
      motion.observable.push_back((m_observable.evaluate(at.u) - rest.observable) / m_si_per_unit);
      if (on_state) on_state(at);
    };
    motion.run = run(
        integrator, moving, options.step_s, end_s - origin_s + options.step_s, observe, progress);
  }
  return motion;
}

}  // namespace twang
