// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/mesh_ladder.hpp"
#include "fem/hex_mesh.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace twang {

/// The tracked scalar as a function of a mesh's displacement: what the film shows, asked of the
/// simulation.
///
/// With an observable in the rig it is that one, its markers glued to the mesh (fixed ones at
/// rest). Without, it is the displacement of the mesh node that moves most in an eigenmode, along
/// its motion there: a trace from elsewhere names no point, so only its shape over time can
/// be compared.
class SimulatedObservable {
 public:
  /// @param mode  the eigenmode that stands in where the rig has no observable, from 0
  SimulatedObservable(const Rig& rig, const MeshRung& rung, int mode = 0);

  /// [m] or [rad]
  [[nodiscard]] double evaluate(const Eigen::VectorXd& u) const;
  /// First-order change of the observable from rest, by a mode shape or velocity field; linear in
  /// `field`.
  [[nodiscard]] double linearized(const Eigen::VectorXd& field) const;
  /// How far a marker moves where the observable changes by one: 1, of an angle the distance of its
  /// markers [m per m or rad].
  [[nodiscard]] double metres_per_unit() const;
  /// Whether it is the rig's own observable.
  [[nodiscard]] bool is_rigs_own() const { return m_is_rigs_own; }

 private:
  const Rig* m_rig;
  bool m_is_rigs_own = false;
  std::vector<Eigen::Vector3d> m_rest;
  std::vector<bool> m_fixed;
  std::vector<MeshPoint> m_points;
  Eigen::Matrix3Xd m_gradient_at_rest;
  Eigen::Vector3d m_direction = Eigen::Vector3d::Zero();
};

/// Why a column of a trace is not what `SimulatedObservable` is, a few words that follow on its
/// name: another observable or a marker's coordinate where the rig states its observable. Empty: it
/// may be.
[[nodiscard]] std::string column_fault(const Rig& rig, const std::string& column);

/// SI units per unit of a trace column, by its suffix: 1e-3 for `_mm`, 1 for `_m`, `_rad` and
/// unknown ones, pi/180 for
/// `_deg`.
[[nodiscard]] double si_per_column_unit(const std::string& column);

/// Smallest subspace of eigenmodes whose frequencies lie within two per cent of mode `index`: their
/// indices, ascending. A square section has two first modes, and which mixture a film shows is
/// decided by the observable.
[[nodiscard]] std::vector<int> mode_cluster(const Eigenmodes& modes, int index);

/// The motion within a cluster that moves the observable most per unit of modal amplitude, scaled
/// so that the observable changes by one; an empty vector if the cluster does not move it.
[[nodiscard]] Eigen::VectorXd unit_observable_shape(const Eigenmodes& modes,
                                                    const std::vector<int>& cluster,
                                                    const SimulatedObservable& observable);

}  // namespace twang
