// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/element_geometry.hpp"

#include "core/error.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>

namespace twang {

Eigen::Matrix3Xd positions_of(const HexMesh& mesh, int element) {
  Eigen::Matrix3Xd X(3, mesh.elements.rows());
  for (int a = 0; a < X.cols(); ++a) X.col(a) = mesh.nodes.col(mesh.elements(a, element));
  return X;
}

namespace {

/// Elements whose nodes differ by no more than this part of their size count as congruent; well
/// above the round-off of node positions.
constexpr double kCongruence = 1e-9;

void check_connectivity(const HexMesh& mesh) {
  if (mesh.num_elements() == 0) throw InputError("the mesh has no element");
  if (mesh.elements.rows() != nodes_per_element(mesh.kind)) {
    throw InputError(fmt::format("the mesh has {} nodes per element, {} needs {}",
                                 mesh.elements.rows(),
                                 to_string(mesh.kind),
                                 nodes_per_element(mesh.kind)));
  }
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (int a = 0; a < mesh.elements.rows(); ++a) {
      const int node = mesh.elements(a, e);
      if (node >= 0 && node < mesh.num_nodes()) continue;
      throw InputError(fmt::format(
          "element {} refers to node {}, must be in 0..{}", e, node, mesh.num_nodes() - 1));
    }
  }
}

bool all_congruent(const HexMesh& mesh) {
  Eigen::Matrix3Xd first = positions_of(mesh, 0);
  first.colwise() -= Eigen::Vector3d(first.col(0));
  const double tolerance = kCongruence * first.cwiseAbs().maxCoeff();
  for (int e = 1; e < mesh.num_elements(); ++e) {
    Eigen::Matrix3Xd X = positions_of(mesh, e);
    X.colwise() -= Eigen::Vector3d(X.col(0));
    if ((X - first).cwiseAbs().maxCoeff() > tolerance) return false;
  }
  return true;
}

/// Where an element's energy is summed; beside its quadrature's points, for hex8e, the middles of
/// the faces.
Quadrature energy_rule(ElementKind kind) {
  Quadrature rule = quadrature(kind);
  if (kind != ElementKind::Hex8e) return rule;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      rule.points.push_back(side * Eigen::Vector3d::Unit(axis));
      rule.weights.push_back(8.0 / 6.0);
    }
  }
  return rule;
}

/// Weights and gradients of one element: a column for each point, three rows for each node and
/// internal mode.
struct PointTable {
  Eigen::VectorXd weights;
  Eigen::MatrixXd gradients;
};

PointTable point_table(ElementKind kind, const Eigen::Matrix3Xd& X, int element) {
  const Quadrature rule = energy_rule(kind);
  const auto num_points = static_cast<Eigen::Index>(rule.points.size());
  const Eigen::Index num_nodes = X.cols();
  const Eigen::Matrix3d middle = X * shape_gradients(kind, Eigen::Vector3d::Zero()).transpose();
  PointTable table;
  table.weights.resize(num_points);
  table.gradients.resize(3 * (num_nodes + num_internal_modes(kind)), num_points);
  for (Eigen::Index g = 0; g < num_points; ++g) {
    const Eigen::Vector3d xi = rule.points[static_cast<std::size_t>(g)];
    const Eigen::Matrix3Xd reference = shape_gradients(kind, xi);
    const Eigen::Matrix3d jacobian = X * reference.transpose();
    const double volume = jacobian.determinant();
    if (!(volume > 0.0)) {
      throw InputError(fmt::format(
          "element {} is turned inside out or flat: its Jacobian determinant is {:.3g} m³, must "
          "be > 0",
          element,
          volume));
    }
    table.weights[g] = volume * rule.weights[static_cast<std::size_t>(g)];
    const Eigen::Matrix3Xd dN = jacobian.transpose().inverse() * reference;
    table.gradients.col(g).head(3 * num_nodes) = dN.reshaped();
    if (num_internal_modes(kind) == 0) continue;
    const Eigen::Matrix3d enhanced = middle.determinant() / volume * middle.transpose().inverse() *
                                     Eigen::Matrix3d(xi.asDiagonal());
    table.gradients.col(g).tail(9) = enhanced.reshaped();
  }
  return table;
}

}  // namespace

ElementGeometry::ElementGeometry(const HexMesh& mesh) : m_kind(mesh.kind) {
  check_connectivity(mesh);
  m_num_batches = (mesh.num_elements() + kLanes - 1) / kLanes;
  m_congruent = all_congruent(mesh);
  const std::size_t num_points = energy_rule(m_kind).points.size();
  const auto num_rows =
      static_cast<std::size_t>(3 * (nodes_per_element(m_kind) + num_internal_modes(m_kind)));
  const auto batch_size = static_cast<std::size_t>(m_congruent ? 1 : kLanes);
  const auto num_tables = static_cast<std::size_t>(m_congruent ? 1 : m_num_batches);
  m_weights.resize(num_tables * num_points * batch_size);
  m_gradients.resize(m_weights.size() * num_rows);
  for (std::size_t slot = 0; slot < num_tables * batch_size; ++slot) {
    // The last batch is filled up with copies of the last element.
    const int element = std::min(static_cast<int>(slot), mesh.num_elements() - 1);
    const PointTable table = point_table(m_kind, positions_of(mesh, element), element);
    const std::size_t lane = slot % batch_size;
    for (std::size_t g = 0; g < num_points; ++g) {
      const std::size_t at = (slot / batch_size) * num_points + g;
      const auto column = static_cast<Eigen::Index>(g);
      m_weights[at * batch_size + lane] = table.weights[column];
      for (std::size_t i = 0; i < num_rows; ++i) {
        m_gradients[(at * num_rows + i) * batch_size + lane] =
            table.gradients(static_cast<Eigen::Index>(i), column);
      }
    }
  }
}

BatchGeometry ElementGeometry::batch(int index) const {
  if (m_congruent) return {true, m_gradients.data(), m_weights.data()};
  const auto at = static_cast<std::size_t>(index);
  const auto num_batches = static_cast<std::size_t>(m_num_batches);
  return {false,
          m_gradients.data() + at * (m_gradients.size() / num_batches),
          m_weights.data() + at * (m_weights.size() / num_batches)};
}

double ElementGeometry::weight(int element, int point) const {
  if (m_congruent) return m_weights[static_cast<std::size_t>(point)];
  return batch(element / kLanes).weights[point * kLanes + element % kLanes];
}

Eigen::MatrixXd ElementGeometry::shape_products(int element) const {
  const Quadrature& rule = quadrature(m_kind);
  const int nodes = nodes_per_element(m_kind);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(nodes, nodes);
  for (std::size_t g = 0; g < rule.points.size(); ++g) {
    const Eigen::VectorXd N = shape_functions(m_kind, rule.points[g]);
    products += weight(element, static_cast<int>(g)) * N * N.transpose();
  }
  return products;
}

}  // namespace twang
