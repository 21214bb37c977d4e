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

/// j0 J0^-T xi_i e_i, the enhanced gradients times the Jacobian's determinant there.
Eigen::Matrix3d internal_gradients(ElementKind kind,
                                   const Eigen::Matrix3Xd& X,
                                   const Eigen::Vector3d& xi) {
  const Eigen::Matrix3d middle = X * shape_gradients(kind, Eigen::Vector3d::Zero()).transpose();
  return middle.determinant() * middle.transpose().inverse() * Eigen::Matrix3d(xi.asDiagonal());
}

}  // namespace

ElementGeometry::ElementGeometry(const HexMesh& mesh) : m_kind(mesh.kind) {
  check_connectivity(mesh);
  m_num_batches = (mesh.num_elements() + kLanes - 1) / kLanes;
  m_congruent = all_congruent(mesh);
  const Quadrature& rule = quadrature(m_kind);
  const auto num_points = rule.points.size();
  const auto num_gradients =
      static_cast<std::size_t>(nodes_per_element(m_kind) + num_internal_modes(m_kind));
  const auto batch_size = static_cast<std::size_t>(m_congruent ? 1 : kLanes);
  const auto num_tables = static_cast<std::size_t>(m_congruent ? 1 : m_num_batches);
  m_weights.resize(num_tables * num_points * batch_size);
  m_gradients.resize(m_weights.size() * num_gradients * 3);
  std::vector<Eigen::Matrix3Xd> reference;
  for (const auto& xi : rule.points) reference.push_back(shape_gradients(m_kind, xi));

  for (std::size_t slot = 0; slot < num_tables * batch_size; ++slot) {
    // The last batch is filled up with copies of the last element.
    const int element = std::min(static_cast<int>(slot), mesh.num_elements() - 1);
    const Eigen::Matrix3Xd X = positions_of(mesh, element);
    for (std::size_t g = 0; g < num_points; ++g) {
      const Eigen::Matrix3d jacobian = X * reference[g].transpose();
      const double volume = jacobian.determinant();
      if (!(volume > 0.0)) {
        throw InputError(fmt::format(
            "element {} is turned inside out or flat: its Jacobian determinant is {:.3g} m³, must "
            "be > 0",
            element,
            volume));
      }
      Eigen::Matrix3Xd dN(3, num_gradients);
      dN.leftCols(X.cols()) = jacobian.transpose().inverse() * reference[g];
      if (dN.cols() > X.cols()) {
        dN.rightCols<3>() = internal_gradients(m_kind, X, rule.points[g]) / volume;
      }
      const std::size_t at = (slot / batch_size) * num_points + g;
      const std::size_t lane = slot % batch_size;
      m_weights[at * batch_size + lane] = volume * rule.weights[g];
      for (std::size_t i = 0; i < num_gradients * 3; ++i) {
        m_gradients[(at * num_gradients * 3 + i) * batch_size + lane] = dN.data()[i];
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
