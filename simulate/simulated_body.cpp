// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/simulated_body.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "fem/attach_weights.hpp"
#include "fem/static_solve.hpp"
#include "simulate/base_motion.hpp"
#include "simulate/detail/nodal_rotations.hpp"
#include "simulate/detail/scene_material.hpp"
#include "simulate/detail/state_stream.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace twang {
namespace {

constexpr double kReleaseSlack = 1e-9;  // of a step, round-off of a product [-]

/// A load, where it takes hold, and what it comes to.
struct AppliedLoad {
  SceneLoad load;
  MeshPoint point;
  Eigen::VectorXd force;      // of a force_n, the whole of it, else empty [N]
  double distance_m = 0.0;    // of a displacement, that is gone while it grows [m]
  double force_then_n = 0.0;  // that held the point at t = 0 [N]

  /// Part of a growing load that is there, and its derivative [1/s]; no jump in either.
  [[nodiscard]] double grown(double time_s) const {
    if (time_s >= load.ramp_s) return 1.0;
    const double angle = 2.0 * kPi * time_s / load.ramp_s;
    return (angle - std::sin(angle)) / (2.0 * kPi);
  }
  [[nodiscard]] double growth_per_s(double time_s) const {
    if (time_s >= load.ramp_s) return 0.0;
    return (1.0 - std::cos(2.0 * kPi * time_s / load.ramp_s)) / load.ramp_s;
  }
};

HexMesh mesh_of(const SceneBody& body) {
  // The cell size plays no role for a mesh file.
  return mesh_part(
      body.rig, body.rig.meshing.file ? kMetresPerMillimetre : body.dx_m, body.element);
}

}  // namespace

struct SimulatedBody::Impl {
  Impl(const Scene& scene, const SceneBody& scene_body, const HexMesh& mesh);

  [[nodiscard]] bool holds(const AppliedLoad& load, double time_s) const;
  [[nodiscard]] Eigen::VectorXd load_force(double time_s) const;
  void check_held_points() const;
  void apply_loads(int index);
  void hold_points(double time_s);
  void start_moving();
  void measure_mass();

  SceneBody from;
  double step_s;
  ElasticBody body;
  std::vector<int> held;
  Eigen::VectorXd gravity_force;  // [N]
  std::vector<AppliedLoad> loads;
  std::vector<const AppliedLoad*> held_points;  // by the integrator now
  const SceneBaseMotion* base = nullptr;
  std::vector<std::string> probe_names;
  std::vector<MeshPoint> probes;
  BodyState state;
  std::unique_ptr<Integrator> integrator;
  Eigen::VectorXd force_now;  // of the loads' forces in the last step [N]
  LedgerWork work;
  double pull_force_n = 0.0;

  double mass_kg = 0.0;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();         // world [m/s²]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();          // of mass, undeformed, rig frame [m]
  Eigen::Matrix3Xd mass_arms;                                // M (X - centre), node by node [kg m]
  Eigen::Matrix3d inverse_spread = Eigen::Matrix3d::Zero();  // of sum m (X - centre)(X - centre)ᵀ
  Eigen::RowVectorXd node_mass;                              // row sums of M [kg]
};

SimulatedBody::Impl::Impl(const Scene& scene, const SceneBody& scene_body, const HexMesh& mesh)
    : from(scene_body),
      step_s(scene.step_s),
      body(mesh, detail::scene_materials(scene_body, mesh), scene_body.model),
      gravity(scene.gravity_m_s2) {
  attach_weights(body, from.rig.masses);
  if (from.clamped) held = clamped_nodes(body.mesh(), from.rig);
  gravity_force = body.gravity_force(from.rotation.transpose() * gravity);
  measure_mass();
}

void SimulatedBody::Impl::measure_mass() {
  const Eigen::Index n = body.mesh().num_nodes();
  const auto weigh = [&](const Eigen::Matrix3Xd& field) -> Eigen::Matrix3Xd {
    const Eigen::VectorXd stacked = Eigen::Map<const Eigen::VectorXd>(field.data(), field.size());
    const Eigen::VectorXd product = body.mass() * stacked;
    return Eigen::Map<const Eigen::Matrix3Xd>(product.data(), 3, n);
  };
  node_mass = weigh(Eigen::Matrix3Xd::Ones(3, n)).row(0);
  mass_kg = node_mass.sum();
  centre = body.mesh().nodes * node_mass.transpose() / mass_kg;
  const Eigen::Matrix3Xd arms = body.mesh().nodes.colwise() - centre;
  mass_arms = weigh(arms);
  inverse_spread = (arms * mass_arms.transpose()).inverse();
}

/// A free body flies and spins as the scene says.
void SimulatedBody::Impl::start_moving() {
  const Eigen::Index n = body.mesh().num_nodes();
  state = {Eigen::VectorXd::Zero(3 * n), Eigen::VectorXd::Zero(3 * n), 0.0};
  if (from.clamped) return;
  const Eigen::Vector3d velocity = from.rotation.transpose() * from.velocity_m_s;
  const Eigen::Vector3d spin = from.rotation.transpose() * from.spin_rad_s;
  for (Eigen::Index i = 0; i < n; ++i)
    state.v.segment<3>(3 * i) = velocity + spin.cross(body.mesh().nodes.col(i) - centre);
}

/// Whether a load is still there in a step that begins at `time_s`.
bool SimulatedBody::Impl::holds(const AppliedLoad& load, double time_s) const {
  return time_s < load.load.release_s - kReleaseSlack * step_s;
}

/// Of all forces that are still there in a step that begins at `time_s`.
Eigen::VectorXd SimulatedBody::Impl::load_force(double time_s) const {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(body.mesh().num_dofs());
  for (const AppliedLoad& load : loads)
    if (load.load.force && holds(load, time_s))
      force += load.grown(time_s + 0.5 * step_s) * load.force;
  return force;
}

/// Each displaced point must be free of the clamps and of the others.
void SimulatedBody::Impl::check_held_points() const {
  Eigen::MatrixXd C(body.mesh().num_dofs(), 0);
  for (const AppliedLoad& load : loads) {
    if (!load.load.displacement) continue;
    C.conservativeResize(Eigen::NoChange, C.cols() + 1);
    C.rightCols<1>() = nodal_force(body.mesh(), load.point, load.load.displacement->normalized());
    for (const int node : held) C.rightCols<1>().segment<3>(3 * node).setZero();
    try {
      check_pulls(C);
    } catch (const InputError& fault) {
      throw InputError(fmt::format("{}.displacement_mm: {}", load.load.key, fault.what()));
    }
  }
}

/// Tells the integrator what presses and pulls in step `index`.
void SimulatedBody::Impl::apply_loads(int index) {
  if (loads.empty()) return;
  const double start_s = (index - 1) * step_s;
  Eigen::VectorXd force = load_force(start_s);
  if (index == 1 || force != force_now) {
    integrator->set_external_force(gravity_force + force);
    force_now = std::move(force);
  }
  hold_points(start_s);
  if (held_points.empty()) return;
  Eigen::VectorXd velocities(static_cast<Eigen::Index>(held_points.size()));
  for (std::size_t i = 0; i < held_points.size(); ++i)
    velocities[static_cast<Eigen::Index>(i)] =
        held_points[i]->distance_m * held_points[i]->growth_per_s(index * step_s);
  integrator->set_point_velocities(velocities);
}

/// Holds what is displaced in a step that begins at `time_s`.
void SimulatedBody::Impl::hold_points(double time_s) {
  std::vector<const AppliedLoad*> points;
  for (const AppliedLoad& load : loads)
    if (load.load.displacement && holds(load, time_s)) points.push_back(&load);
  if (points == held_points) return;
  std::vector<HeldPoint> held_now;
  for (const AppliedLoad* load : points)
    held_now.push_back({load->point, *load->load.displacement});
  integrator->hold_points(held_now);
  held_points = std::move(points);
}

SimulatedBody::SimulatedBody(const Scene& scene, std::size_t index)
    : m_impl(std::make_unique<Impl>(scene, scene.bodies[index], mesh_of(scene.bodies[index]))) {
  Impl& impl = *m_impl;
  const HexMesh& mesh = impl.body.mesh();
  for (const SceneLoad& load : scene.loads)
    if (load.body == index) impl.loads.push_back({load, locate(mesh, load.at), {}});
  // A load grows in whole steps.
  for (AppliedLoad& load : impl.loads)
    load.load.ramp_s = std::ceil(load.load.ramp_s / impl.step_s - kReleaseSlack) * impl.step_s;
  impl.check_held_points();
  for (const SceneProbe& probe : scene.probes) {
    if (probe.body != index) continue;
    impl.probe_names.push_back(probe.marker);
    impl.probes.push_back(locate(mesh, impl.from.rig.find_marker(probe.marker)->position));
  }
  for (const SceneBaseMotion& motion : scene.base_motions)
    if (motion.body == index) impl.base = &motion;
  impl.start_moving();
  IntegratorOptions options;
  options.step_s = scene.step_s;
  options.scheme = scene.scheme;
  options.solver.kind = impl.from.solver;
  impl.integrator = std::make_unique<Integrator>(impl.body, impl.held, options, impl.gravity_force);
  impl.force_now = Eigen::VectorXd::Zero(mesh.num_dofs());
}
SimulatedBody::SimulatedBody(SimulatedBody&&) noexcept = default;
SimulatedBody::~SimulatedBody() = default;

void SimulatedBody::settle(const ProgressCallback& progress) {
  Impl& impl = *m_impl;
  if (impl.loads.empty()) return;
  StaticLoad load;
  load.force = impl.gravity_force;
  std::vector<AppliedLoad*> pulled;
  for (AppliedLoad& applied : impl.loads) {
    if (applied.load.force)
      applied.force = nodal_force(impl.body.mesh(), applied.point, *applied.load.force);
    if (applied.load.ramp_s > 0.0) continue;
    if (applied.load.displacement) {
      pulled.push_back(&applied);
      load.more_pulls.push_back({applied.point, *applied.load.displacement});
    } else {
      load.force += applied.force;
    }
  }
  if (!impl.from.clamped) return;  // its loads grow
  StaticOptions options;
  options.progress = progress;
  // A factor repays itself here up to a larger size than in a step.
  options.solver.kind = impl.from.solver;
  const StaticResult result = solve_static(impl.body, impl.held, load, options);
  if (!result.usable())
    throw NumericalFailure(fmt::format("{}: the body \"{}\" cannot be loaded: {}",
                                       impl.loads.front().load.key,
                                       impl.from.name,
                                       result.message));
  impl.state.u = result.u;
  for (std::size_t i = 0; i < pulled.size(); ++i) pulled[i]->force_then_n = result.pull_forces_n[i];
  if (!pulled.empty()) impl.pull_force_n = pulled.front()->force_then_n;
  for (AppliedLoad& applied : impl.loads) {
    if (!applied.load.displacement || applied.load.ramp_s == 0.0) continue;
    const Eigen::Vector3d sag = interpolate(applied.point, result.u);
    applied.distance_m =
        applied.load.displacement->norm() - sag.dot(applied.load.displacement->normalized());
  }
}

StepReport SimulatedBody::step(int index) {
  Impl& impl = *m_impl;
  impl.apply_loads(index);
  if (impl.base != nullptr)
    impl.integrator->set_base_velocity(
        impl.from.rotation.transpose() *
        base_velocity(impl.base->time_s, impl.base->displacement, index * impl.step_s));
  const Eigen::VectorXd u_before = impl.state.u;
  StepReport report = impl.integrator->step(impl.state);
  impl.work = {};
  if (report.termination != Termination::Converged) return report;
  impl.state.time_s = index * impl.step_s;
  // The integrator counts gravity with the loads; here it is a potential.
  impl.work.external_j =
      impl.force_now.dot(impl.state.u - u_before) + report.work.base_j + report.work.points_j;
  impl.work.damping_j = report.work.damping_j;
  return report;
}

const std::string& SimulatedBody::name() const { return m_impl->from.name; }
const ElasticBody& SimulatedBody::body() const { return m_impl->body; }
const std::vector<int>& SimulatedBody::held_nodes() const { return m_impl->held; }
const BodyState& SimulatedBody::state() const { return m_impl->state; }
const LedgerWork& SimulatedBody::last_work() const { return m_impl->work; }
double SimulatedBody::pull_force_n() const { return m_impl->pull_force_n; }
const std::vector<std::string>& SimulatedBody::probe_names() const { return m_impl->probe_names; }

MechanicalState SimulatedBody::mechanical_state() const {
  const Impl& impl = *m_impl;
  const Eigen::Index n = impl.body.mesh().num_nodes();
  const Eigen::VectorXd Mv = impl.body.mass() * impl.state.v;
  MechanicalState now;
  now.kinetic_j = 0.5 * impl.state.v.dot(Mv);
  now.elastic_j = impl.body.elastic_energy(impl.state.u);
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d l = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d p_node = Mv.segment<3>(3 * i);
    p += p_node;
    l += (impl.body.mesh().nodes.col(i) + impl.state.u.segment<3>(3 * i)).cross(p_node);
  }
  now.linear = impl.from.rotation * p;
  now.angular = impl.from.rotation * l + impl.from.position.cross(now.linear);
  const Eigen::Vector3d centre_at_start = impl.from.position + impl.from.rotation * impl.centre;
  now.gravity_j =
      -impl.mass_kg * impl.gravity.dot(centre_at_start) - impl.gravity_force.dot(impl.state.u);
  return now;
}

BodyMotion SimulatedBody::motion() const {
  const Impl& impl = *m_impl;
  const Eigen::Index n = impl.body.mesh().num_nodes();
  const auto by_node = [n](const Eigen::VectorXd& field) {
    return Eigen::Map<const Eigen::Matrix3Xd>(field.data(), 3, n);
  };
  const Eigen::Vector3d moved = by_node(impl.state.u) * impl.node_mass.transpose() / impl.mass_kg;
  const Eigen::Matrix3Xd x = impl.body.mesh().nodes + by_node(impl.state.u);
  BodyMotion motion;
  motion.centre = impl.from.position + impl.from.rotation * (impl.centre + moved);
  motion.velocity_m_s =
      impl.from.rotation * (by_node(impl.state.v) * impl.node_mass.transpose() / impl.mass_kg);
  // The affine map from X to x that fits best, node by node by mass.
  const Eigen::Matrix3d mean_gradient =
      (x.colwise() - (impl.centre + moved)) * impl.mass_arms.transpose() * impl.inverse_spread;
  const Eigen::Matrix3d turned = detail::orthogonal_factor(mean_gradient);
  motion.rotation = Eigen::Quaterniond(Eigen::Matrix3d(impl.from.rotation * turned));
  if (motion.rotation.w() < 0.0) motion.rotation.coeffs() *= -1.0;
  return motion;
}

Eigen::Vector3d SimulatedBody::probe(std::size_t index) const {
  const Impl& impl = *m_impl;
  const Eigen::Vector3d rest = impl.from.rig.find_marker(impl.probe_names[index])->position;
  return impl.from.position +
         impl.from.rotation * (rest + interpolate(impl.probes[index], impl.state.u));
}

Eigen::Matrix3Xd SimulatedBody::nodes_at_start() const {
  return (m_impl->from.rotation * m_impl->body.mesh().nodes).colwise() + m_impl->from.position;
}

const Eigen::Matrix3d& SimulatedBody::rotation() const { return m_impl->from.rotation; }

Eigen::VectorXd SimulatedBody::in_world(const Eigen::VectorXd& field) const {
  Eigen::VectorXd turned(field.size());
  for (Eigen::Index i = 0; i < field.size(); i += 3)
    turned.segment<3>(i) = m_impl->from.rotation * field.segment<3>(i);
  return turned;
}

std::string SimulatedBody::solver() const { return m_impl->integrator->solver(); }

void SimulatedBody::save(detail::StateWriter& writer) const {
  const Impl& impl = *m_impl;
  writer.write(impl.state.u);
  writer.write(impl.state.v);
  writer.write(impl.state.time_s);
  writer.write(impl.pull_force_n);
  writer.write(impl.force_now);
  for (const AppliedLoad& load : impl.loads) {
    writer.write(load.distance_m);
    writer.write(load.force_then_n);
  }
  impl.integrator->save(writer);
}

void SimulatedBody::restore(detail::StateReader& reader) {
  Impl& impl = *m_impl;
  const Eigen::Index dofs = impl.body.mesh().num_dofs();
  impl.state.u = reader.read_vector(dofs);
  impl.state.v = reader.read_vector(dofs);
  impl.state.time_s = reader.read_number();
  impl.pull_force_n = reader.read_number();
  impl.force_now = reader.read_vector(dofs);
  for (AppliedLoad& load : impl.loads) {
    load.distance_m = reader.read_number();
    load.force_then_n = reader.read_number();
    if (load.load.force) load.force = nodal_force(impl.body.mesh(), load.point, *load.load.force);
  }
  if (impl.state.time_s > 0.0) impl.hold_points(impl.state.time_s - impl.step_s);
  impl.integrator->restore(reader);
}

}  // namespace twang
