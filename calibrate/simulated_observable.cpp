// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/simulated_observable.hpp"

#include "core/units.hpp"
#include "rigs/observable.hpp"

#include <fmt/format.h>

#include <cmath>

namespace twang {

SimulatedObservable::SimulatedObservable(const Rig& rig, const MeshRung& rung, int mode)
    : m_rig(&rig) {
  if (rig.observable) {
    m_is_rigs_own = true;
    for (const std::string& id : rig.observable->markers) {
      const Marker& marker = *rig.find_marker(id);
      m_rest.push_back(marker.position);
      m_fixed.push_back(marker.fixed);
      m_points.push_back(marker.fixed ? MeshPoint{} : locate(rung.mesh, marker.position));
    }
    m_gradient_at_rest = observable_gradient(rig, m_rest);
    return;
  }
  const Eigen::Map<const Eigen::Matrix3Xd> shape(
      rung.modes.shapes.col(mode).data(), 3, rung.mesh.num_nodes());
  Eigen::Index most = 0;
  shape.colwise().squaredNorm().maxCoeff(&most);
  m_direction = shape.col(most).normalized();
  m_points.push_back(locate(rung.mesh, rung.mesh.nodes.col(most)));
}

double SimulatedObservable::evaluate(const Eigen::VectorXd& u) const {
  if (!m_is_rigs_own) return m_direction.dot(interpolate(m_points.front(), u));
  std::vector<Eigen::Vector3d> positions = m_rest;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!m_fixed[i]) positions[i] += interpolate(m_points[i], u);
  }
  return evaluate_observable(*m_rig, positions, m_rest);
}

double SimulatedObservable::linearized(const Eigen::VectorXd& field) const {
  if (!m_is_rigs_own) return m_direction.dot(interpolate(m_points.front(), field));
  double change = 0.0;
  for (std::size_t i = 0; i < m_points.size(); ++i) {
    if (!m_fixed[i]) {
      change +=
          m_gradient_at_rest.col(static_cast<Eigen::Index>(i)).dot(interpolate(m_points[i], field));
    }
  }
  return change;
}

double SimulatedObservable::metres_per_unit() const {
  const bool angle = m_is_rigs_own && m_rig->observable->kind == ObservableKind::Angle;
  return angle ? (m_rest[1] - m_rest[0]).norm() : 1.0;
}

std::string column_fault(const Rig& rig, const std::string& column) {
  if (!rig.observable) return {};
  const std::string own = observable_column(rig.observable->kind);
  bool other = column.starts_with("observable_") && column != own;
  for (const Marker& marker : rig.markers) other = other || column.starts_with(marker.id + ".");
  return other ? fmt::format("is not the rig's observable, must be {}", own) : std::string();
}

double si_per_column_unit(const std::string& column) {
  if (column.ends_with("_mm")) return kMetresPerMillimetre;
  if (column.ends_with("_deg")) return kRadiansPerDegree;
  return 1.0;
}

std::vector<int> mode_cluster(const Eigenmodes& modes, int index) {
  constexpr double kNearEqual =
      0.02;  // of frequency: symmetric sections differ by less, other modes by more
  std::vector<int> cluster;
  const double centre_hz = modes.natural_frequency_hz(index);
  for (int i = 0; i < modes.count(); ++i) {
    if (std::abs(modes.natural_frequency_hz(i) / centre_hz - 1.0) < kNearEqual)
      cluster.push_back(i);
  }
  return cluster;
}

Eigen::VectorXd unit_observable_shape(const Eigenmodes& modes,
                                      const std::vector<int>& cluster,
                                      const SimulatedObservable& observable) {
  Eigen::VectorXd shape = Eigen::VectorXd::Zero(modes.shapes.rows());
  double square_sum = 0.0;
  double largest_motion = 0.0;
  for (const int index : cluster) {
    const double participation = observable.linearized(modes.shapes.col(index));
    shape += participation * modes.shapes.col(index);
    square_sum += participation * participation;
    largest_motion = std::max(largest_motion, modes.shapes.col(index).lpNorm<Eigen::Infinity>());
  }
  constexpr double kUnmoved =
      1e-9;  // participation over the shape's own peak: round-off of a symmetric mode
  if (observable.is_rigs_own() && std::sqrt(square_sum) < kUnmoved * largest_motion) return {};
  return shape / square_sum;
}

}  // namespace twang
