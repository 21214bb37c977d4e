// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/simulated_body.hpp"

#include "core/error.hpp"
#include "core/units.hpp"
#include "fem/multigrid_preconditioner.hpp"
#include "fem/static_solve.hpp"
#include "simulate/base_motion.hpp"
#include "simulate/detail/nodal_rotations.hpp"
#include "simulate/detail/scene_material.hpp"
#include "simulate/detail/state_stream.hpp"
#include "simulate/static_newton.hpp"

#include <fmt/format.h>

#include <utility>

namespace twang {
namespace {

constexpr double kReleaseSlack = 1e-9;  // of a step, round-off of a product [-]

/// A load and the nodal force that stands for it until it is let go.
struct HeldLoad {
  SceneLoad load;
  MeshPoint point;
  Eigen::VectorXd force;
};

HexMesh mesh_of(const SceneBody& body) {
  // The cell size plays no role for a mesh file.
  return mesh_part(
      body.rig, body.rig.meshing.file ? kMetresPerMillimetre : body.dx_m, body.element);
}

}  // namespace

struct SimulatedBody::Impl {
  Impl(const Scene& scene, const SceneBody& scene_body, const HexMesh& mesh);

  [[nodiscard]] Eigen::VectorXd load_force(double time_s) const;
  void start_moving();
  void measure_mass();

  SceneBody from;
  double step_s;
  ElasticBody body;
  std::vector<int> held;
  Eigen::VectorXd gravity_force;  // [N]
  std::vector<HeldLoad> loads;
  const SceneBaseMotion* base = nullptr;
  std::vector<std::string> probe_names;
  std::vector<MeshPoint> probes;
  BodyState state;
  std::unique_ptr<Integrator> integrator;
  Eigen::VectorXd force_now;  // of the loads in the last step [N]
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
  for (const PointMass& weight : from.rig.masses)
    body.add_point_mass(locate(body.mesh(), weight.at), weight.mass_kg);
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

/// Of all loads that are still there in a step that begins at `time_s`.
Eigen::VectorXd SimulatedBody::Impl::load_force(double time_s) const {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(body.mesh().num_dofs());
  for (const HeldLoad& held_load : loads)
    if (time_s < held_load.load.release_s - kReleaseSlack * step_s) force += held_load.force;
  return force;
}

SimulatedBody::SimulatedBody(const Scene& scene, std::size_t index)
    : m_impl(std::make_unique<Impl>(scene, scene.bodies[index], mesh_of(scene.bodies[index]))) {
  Impl& impl = *m_impl;
  const HexMesh& mesh = impl.body.mesh();
  for (const SceneLoad& load : scene.loads)
    if (load.body == index) impl.loads.push_back({load, locate(mesh, load.at), {}});
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
  HeldLoad* pulled = nullptr;
  for (HeldLoad& held_load : impl.loads) {
    if (held_load.load.displacement) {
      pulled = &held_load;
      load.pulled_point = held_load.point;
      load.pull = *held_load.load.displacement;
    } else {
      held_load.force = nodal_force(impl.body.mesh(), held_load.point, *held_load.load.force);
      load.force += held_load.force;
    }
  }
  StaticOptions options;
  options.progress = progress;
  const FreeDofs free(impl.body.mesh().num_nodes(), impl.held);
  const StiffnessSolverOptions& solver = impl.integrator->options().solver;
  const StaticResult result =
      prefers_multigrid(impl.body, free, solver)
          ? solve_static_matrix_free(impl.body, impl.held, load, options, solver)
          : solve_static(impl.body, impl.held, load, options);
  if (!result.usable())
    throw NumericalFailure(fmt::format("{}: the body \"{}\" cannot be loaded: {}",
                                       impl.loads.front().load.key,
                                       impl.from.name,
                                       result.message));
  impl.state.u = result.u;
  if (pulled != nullptr) {
    impl.pull_force_n = result.pull_force_n;
    pulled->force =
        nodal_force(impl.body.mesh(), pulled->point, result.pull_force_n * load.pull.normalized());
  }
}

StepReport SimulatedBody::step(int index) {
  Impl& impl = *m_impl;
  const double start_s = (index - 1) * impl.step_s;
  if (!impl.loads.empty()) {
    Eigen::VectorXd force = impl.load_force(start_s);
    if (index == 1 || force != impl.force_now) {
      impl.integrator->set_external_force(impl.gravity_force + force);
      impl.force_now = std::move(force);
    }
  }
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
  impl.work.external_j = impl.force_now.dot(impl.state.u - u_before) + report.work.base_j;
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
  for (const HeldLoad& load : impl.loads) writer.write(load.force);
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
  for (HeldLoad& load : impl.loads) load.force = reader.read_vector(dofs);
  impl.integrator->restore(reader);
}

}  // namespace twang
