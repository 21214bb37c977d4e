// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/energy.hpp"

#include <Eigen/Dense>

namespace twang {

BodyEnergy measure_energy(const ElasticBody& body, const BodyState& state) {
  return {0.5 * state.v.dot(body.mass() * state.v), body.elastic_energy(state.u)};
}

BodyMomentum measure_momentum(const ElasticBody& body, const BodyState& state) {
  const Eigen::VectorXd Mv = body.mass() * state.v;
  BodyMomentum momentum;
  for (int i = 0; i < body.mesh().num_nodes(); ++i) {
    const Eigen::Vector3d x = body.mesh().nodes.col(i) + state.u.segment<3>(3 * i);
    const Eigen::Vector3d p = Mv.segment<3>(3 * i);
    momentum.linear += p;
    momentum.angular += x.cross(p);
  }
  return momentum;
}

}  // namespace twang
