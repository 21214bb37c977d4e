// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/progress.hpp"
#include "fem/elastic_body.hpp"
#include "simulate/energy_ledger.hpp"
#include "simulate/integrators.hpp"
#include "simulate/scene.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <memory>
#include <string>
#include <vector>

namespace twang {

/// Where a body is as a whole, in the world's frame.
struct BodyMotion {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();        ///< of mass [m]
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< of the centre of mass
  /// World from rig, w >= 0: the rotation in the affine map that fits the body best.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};

/// A body of a scene on its way through time. Inside it moves in the frame of its rig, which stands
/// still in the world at the body's starting pose; what it tells is in the world's frame.
class SimulatedBody {
 public:
  /// Keeps a reference to `scene`. Meshes the body and gives it its material; it is undeformed,
  /// with its velocity.
  /// @throws InputError if the part cannot be meshed, or the material file's E_n belongs to another
  /// mesh
  SimulatedBody(const Scene& scene, std::size_t index);
  SimulatedBody(SimulatedBody&&) noexcept;
  ~SimulatedBody();

  /// Brings a loaded body to equilibrium under gravity and loads; others stay as they are.
  /// @throws NumericalFailure if there is none; Cancelled
  void settle(const ProgressCallback& progress);

  /// Advances by one step, loads being let go when their time has come.
  /// @param index  of the step: it ends at index times step_s
  StepReport step(int index);

  [[nodiscard]] const std::string& name() const;
  [[nodiscard]] const ElasticBody& body() const;
  [[nodiscard]] const std::vector<int>& held_nodes() const;
  [[nodiscard]] const BodyState& state() const;
  /// Work over the last step.
  [[nodiscard]] const LedgerWork& last_work() const;
  [[nodiscard]] MechanicalState mechanical_state() const;
  [[nodiscard]] BodyMotion motion() const;
  /// Where a probed marker is [m].
  [[nodiscard]] Eigen::Vector3d probe(std::size_t index) const;
  [[nodiscard]] const std::vector<std::string>& probe_names() const;
  /// Nodes of the undeformed mesh at the starting pose, (3 x num_nodes) [m].
  [[nodiscard]] Eigen::Matrix3Xd nodes_at_start() const;
  /// World from the frame in which the body's fields are.
  [[nodiscard]] const Eigen::Matrix3d& rotation() const;
  /// A nodal vector field (3 num_nodes), turned into the world's frame.
  [[nodiscard]] Eigen::VectorXd in_world(const Eigen::VectorXd& field) const;
  /// How its linear equations are solved, in a few words.
  [[nodiscard]] std::string solver() const;
  /// Force that holds the pulled point before it is let go, 0 without one [N].
  [[nodiscard]] double pull_force_n() const;

  void save(detail::StateWriter& writer) const;
  void restore(detail::StateReader& reader);

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

}  // namespace twang
