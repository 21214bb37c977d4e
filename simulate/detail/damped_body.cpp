// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/damped_body.hpp"

#include "core/error.hpp"
#include "fem/threads.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace twang::detail {
namespace {

constexpr double kStiffInVolume = 100.0;  // lambda over mu, a Poisson's ratio of 0.495 [-]
constexpr double kDifference = 1e-3;      // of the way v / gamma, for differences of K [-]

std::vector<int> checked_nodes(const HexMesh& mesh, const std::vector<int>& nodes) {
  for (const int node : nodes)
    if (node < 0 || node >= mesh.num_nodes())
      throw InputError(
          fmt::format("held node {} does not exist, the mesh has {}", node, mesh.num_nodes()));
  return nodes;
}

/// The scalar factor of a mass matrix, which acts on x, y and z alike.
Eigen::SparseMatrix<double> nodal_part(const SparseMatrix& mass) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int j = 0; j < mass.cols(); j += 3)
    for (SparseMatrix::InnerIterator it(mass, j); it; ++it)
      if (it.row() % 3 == 0) entries.emplace_back(it.row() / 3, j / 3, it.value());
  Eigen::SparseMatrix<double> nodal(mass.rows() / 3, mass.cols() / 3);
  nodal.setFromTriplets(entries.begin(), entries.end());
  return nodal;
}

}  // namespace

DampedBody::DampedBody(const ElasticBody& body, const std::vector<int>& held_nodes)
    : m_body(body),
      m_held_nodes(checked_nodes(body.mesh(), held_nodes)),
      m_free(body.mesh().num_nodes(), held_nodes),
      m_nodal_mass(nodal_part(body.mass())) {
  const auto& materials = body.materials();
  m_a = materials.front().damping_mass_a_per_s;
  m_b = materials.front().damping_stiffness_b_s;
  for (std::size_t i = 1; i < materials.size(); ++i) {
    if (materials[i].damping_mass_a_per_s != m_a)
      throw InputError(fmt::format(
          "damping_mass_a_per_s is {} for {} and {} for {}, must be the same for all materials of "
          "a body",
          m_a,
          body.mesh().material_names.front(),
          materials[i].damping_mass_a_per_s,
          body.mesh().material_names[i]));
    m_one_b = m_one_b && materials[i].damping_stiffness_b_s == m_b;
  }
  for (const ElasticMaterial& material : materials) {
    m_b = std::max(m_b, material.damping_stiffness_b_s);
    const LameConstants lame = lame_constants(material.youngs_modulus_pa, material.poissons_ratio);
    m_stiff_in_volume = m_stiff_in_volume || (material.damping_stiffness_b_s > 0.0 &&
                                              lame.lambda > kStiffInVolume * lame.mu);
  }
}

void DampedBody::clear_held(Eigen::VectorXd& w) const {
  for (const int node : m_held_nodes) w.segment<3>(3 * node).setZero();
}

Eigen::VectorXd DampedBody::mass_product(const Eigen::VectorXd& w) const {
  Eigen::VectorXd product = full_mass_product(w);
  clear_held(product);
  return product;
}

Eigen::VectorXd DampedBody::full_mass_product(const Eigen::VectorXd& w) const {
  Eigen::VectorXd product(w.size());
  for_each_range(static_cast<int>(m_nodal_mass.cols()), [&](int first, int last) {
    for (int j = first; j < last; ++j) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (Eigen::SparseMatrix<double>::InnerIterator it(m_nodal_mass, j); it; ++it)
        sum += it.value() * w.segment<3>(3 * it.row());
      product.segment<3>(3 * j) = sum;
    }
  });
  return product;
}

Eigen::VectorXd DampedBody::damping_force(const Eigen::VectorXd& u,
                                          const Eigen::VectorXd& v) const {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(v.size());
  if (m_b > 0.0) force += m_body.stiffness_damping_force(u, v);
  if (m_a != 0.0) force += m_a * full_mass_product(v);
  return force;
}

Eigen::VectorXd DampedBody::resisting_force(const Eigen::VectorXd& u,
                                            const Eigen::VectorXd& v) const {
  Eigen::VectorXd force = m_body.internal_force(u);
  if (m_b > 0.0) force += m_body.stiffness_damping_force(u, v);
  if (m_a != 0.0) force += m_a * mass_product(v);
  clear_held(force);
  return force;
}

Eigen::VectorXd DampedBody::step_product(const Linearization& at, const Eigen::VectorXd& w) const {
  Eigen::VectorXd product = (at.mu_per_s2 + at.gamma_per_s * m_a) * mass_product(w);
  if (at.gamma_per_s == 0.0) {
    product += m_body.stiffness_product(at.u, w);
  } else if (at.differences) {
    product += m_body.stiffness_product(at.u, w);
    product += at.gamma_per_s * m_body.stiffness_damping_force(at.u, w);
    const Eigen::VectorXd ahead = (kDifference / at.gamma_per_s) * at.v;
    product +=
        (0.5 * at.gamma_per_s / kDifference) * (m_body.stiffness_damping_force(at.u + ahead, w) -
                                                m_body.stiffness_damping_force(at.u - ahead, w));
  } else if (m_one_b) {
    const double weight = 1.0 + at.gamma_per_s * m_b;
    product += weight * m_body.stiffness_product(at.u + (m_b / weight) * at.v, w);
  } else {
    product += m_body.stiffness_product(at.u, w);
    product += at.gamma_per_s * m_body.stiffness_damping_force(at.u + at.v / at.gamma_per_s, w);
  }
  clear_held(product);
  return product;
}

SparseMatrix DampedBody::step_matrix(const Linearization& at) const {
  const double ahead = at.differences ? 0.0 : 1.0;
  SparseMatrix H;
  if (at.gamma_per_s == 0.0) {
    H = m_body.stiffness(at.u);
  } else if (m_one_b) {
    const double weight = 1.0 + at.gamma_per_s * m_b;
    H = m_body.stiffness(at.u + (ahead * m_b / weight) * at.v);
    H *= weight;
  } else {
    H = m_body.stiffness(at.u);
    H += at.gamma_per_s * m_body.stiffness_damping(at.u + (ahead / at.gamma_per_s) * at.v);
  }
  m_body.add_scaled_mass(at.mu_per_s2 + at.gamma_per_s * m_a, H);
  return m_free.restrict_matrix(H);
}

Eigen::VectorXd DampedBody::inertia_diagonal(const Linearization& at) const {
  const Eigen::VectorXd diagonal = m_body.mass().diagonal();
  return (at.mu_per_s2 + at.gamma_per_s * m_a) * m_free.restrict_vector(diagonal);
}

}  // namespace twang::detail
