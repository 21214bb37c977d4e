// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/simulated_release.hpp"

#include "calibrate/detail/step_error.hpp"
#include "core/error.hpp"
#include "fem/attach_weights.hpp"
#include "fem/static_solve.hpp"
#include "simulate/integrators.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

StaticResult hold(const Rig& rig,
                  const ElasticBody& body,
                  const std::vector<int>& held_nodes,
                  const Eigen::VectorXd& dead_force,
                  const SimulatedReleaseOptions& options) {
  const Release& release = *rig.release;
  const MeshPoint point = locate(body.mesh(), release.at);
  StaticLoad load;
  load.force = dead_force;
  if (release.displacement) {
    load.pulled_point = point;
    load.pull = options.factor * *release.displacement;
  } else {
    const Eigen::VectorXd pull = nodal_force(body.mesh(), point, options.factor * *release.force);
    load.force = dead_force.size() == 0 ? pull : dead_force + pull;
  }
  StaticOptions statics;
  statics.load_steps = 4;
  statics.progress = [&](const Progress& progress) {
    return !options.progress || options.progress({"bending", progress.done, progress.total});
  };
  return solve_static(body, held_nodes, load, statics);
}

}  // namespace

RecordedMotion::RecordedMotion(std::vector<int> nodes, Eigen::Index num_dofs, double step_s)
    : m_nodes(std::move(nodes)), m_num_dofs(num_dofs), m_step_s(step_s) {}

void RecordedMotion::append(const Eigen::VectorXd& u) {
  Eigen::VectorXd state(3 * static_cast<Eigen::Index>(m_nodes.size()));
  Eigen::Index at = 0;
  for (const int node : m_nodes) {
    state.segment<3>(at) = u.segment<3>(3 * node);
    at += 3;
  }
  m_states.push_back(std::move(state));
}

Eigen::VectorXd RecordedMotion::displacement(double time_s) const {
  const auto last = static_cast<std::ptrdiff_t>(m_states.size()) - 1;
  const double position = std::clamp(time_s / m_step_s, 0.0, static_cast<double>(last));
  const auto i =
      std::min(static_cast<std::ptrdiff_t>(position), std::max<std::ptrdiff_t>(last - 1, 0));
  const double x = position - static_cast<double>(i);
  const auto at = [&](std::ptrdiff_t k) -> const Eigen::VectorXd& {
    // let go from rest, it moves before the release as after it: an even function
    return m_states[static_cast<std::size_t>(std::min(std::abs(k), last))];
  };
  const double a = 0.5 * x * ((2.0 - x) * x - 1.0);
  const double b = 0.5 * (x * x * (3.0 * x - 5.0) + 2.0);
  const double c = 0.5 * x * ((4.0 - 3.0 * x) * x + 1.0);
  const double d = 0.5 * x * x * (x - 1.0);
  const Eigen::VectorXd state = a * at(i - 1) + b * at(i) + c * at(i + 1) + d * at(i + 2);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(m_num_dofs);
  Eigen::Index from = 0;
  for (const int node : m_nodes) {
    u.segment<3>(3 * node) = state.segment<3>(from);
    from += 3;
  }
  return u;
}

RecordedMotion simulate_release(const Rig& rig,
                                const HexMesh& mesh,
                                const std::vector<int>& held_nodes,
                                const ElasticMaterial& material,
                                const std::vector<int>& nodes,
                                const SimulatedReleaseOptions& options) {
  const ElasticMaterial stepped = detail::without_step_error(material, options.steps_per_period);
  ElasticBody body(mesh, std::vector<ElasticMaterial>(mesh.material_names.size(), stepped));
  attach_weights(body, rig.masses);
  Eigen::VectorXd dead_force;
  if (rig.gravity_m_s2) dead_force = body.gravity_force(*rig.gravity_m_s2);
  StaticResult held = hold(rig, body, held_nodes, dead_force, options);
  if (!held.usable())
    throw NumericalFailure(fmt::format("the release cannot be reached: {}", held.message));

  IntegratorOptions stepping;
  stepping.step_s = 1.0 / (options.frequency_hz * options.steps_per_period);
  Integrator integrator(body, held_nodes, stepping, dead_force);
  BodyState state;
  state.v = Eigen::VectorXd::Zero(held.u.size());
  state.u = std::move(held.u);
  RecordedMotion motion(nodes, mesh.num_dofs(), stepping.step_s);
  const auto keep = [&](const BodyState& now) { motion.append(now.u); };
  const RunSummary summary =
      run(integrator, state, stepping.step_s, options.duration_s, keep, options.progress);
  if (!summary.usable()) throw NumericalFailure(summary.message);
  return motion;
}

}  // namespace twang
