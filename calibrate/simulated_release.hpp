// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/progress.hpp"
#include "fem/elastic_body.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang {

/// A body's free motion as it was simulated, kept at the nodes that are looked at.
class RecordedMotion {
 public:
  /// @param nodes  looked at, ascending
  RecordedMotion(std::vector<int> nodes, Eigen::Index num_dofs, double step_s);
  void append(const Eigen::VectorXd& u);

  /// Displacement of every node (3 num_nodes) [m], 0 where nobody looks: the first state before
  /// time 0, by Catmull and Rom's cubics after it, the last state beyond the end.
  [[nodiscard]] Eigen::VectorXd displacement(double time_s) const;

 private:
  std::vector<int> m_nodes;
  Eigen::Index m_num_dofs;
  double m_step_s;
  std::vector<Eigen::VectorXd> m_states;  // (3 nodes looked at)
};

struct SimulatedReleaseOptions {
  double factor = 1.0;        ///< on the rig's release: displacement or force [-]
  double duration_s = 1.0;    ///< after it is let go [s]
  double frequency_hz = 0.0;  ///< of the slowest mode of interest: the step is a part of its period
  double steps_per_period = 60.0;  ///< their period error is taken out
  ProgressCallback progress = {};
};

/// Holds a body as the rig's release says, in its large static deflection, lets it go from rest and
/// simulates what follows: trapezoidal Newmark with the body's own material law, gravity if the rig
/// has it.
/// @param material  of the whole mesh
/// @param nodes     whose motion is kept, ascending
/// @throws NumericalFailure if the release cannot be reached or a step does not converge; Cancelled
[[nodiscard]] RecordedMotion simulate_release(const Rig& rig,
                                              const HexMesh& mesh,
                                              const std::vector<int>& held_nodes,
                                              const ElasticMaterial& material,
                                              const std::vector<int>& nodes,
                                              const SimulatedReleaseOptions& options);

}  // namespace twang
