// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/termination.hpp"
#include "fem/elastic_body.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// A load on a body: dead forces, and at most one point whose displacement is prescribed along a
/// direction, free across it.
struct StaticLoad {
  Eigen::VectorXd force;  ///< (3 num_nodes) [N]; empty: none
  std::optional<MeshPoint> pulled_point;
  Eigen::Vector3d pull =
      Eigen::Vector3d::Zero();  ///< displacement of that point: direction and length [m]
};

struct StaticOptions {
  double tolerance = 1e-9;  ///< of the residual, relative to the largest internal force met [-]
  int max_newton_iterations = 60;
  int load_steps = 1;  ///< halved further by itself when Newton fails
  void check() const;
};

struct StaticResult {
  Eigen::VectorXd u;  ///< (3 num_nodes) [m]
  Eigen::VectorXd
      reaction;  ///< internal minus applied force; not zero at held nodes and the pulled point [N]
  double pull_force_n = 0.0;  ///< that the pulled point carries along `pull` [N]
  int newton_iterations = 0;
  Termination termination = Termination::NotRun;
  std::string message;
  [[nodiscard]] bool usable() const { return termination == Termination::Converged; }
};

/// Static equilibrium of a body with `held_nodes` at rest: Newton with a line search on the energy.
/// @param start  displacement to start from; empty: undeformed
[[nodiscard]] StaticResult solve_static(const ElasticBody& body,
                                        const std::vector<int>& held_nodes,
                                        const StaticLoad& load,
                                        const StaticOptions& options = {},
                                        const Eigen::VectorXd& start = {});

}  // namespace twang
