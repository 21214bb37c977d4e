// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/material.hpp"
#include "fem/constitutive.hpp"
#include "fem/hex_mesh.hpp"

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <memory>
#include <vector>

namespace twang {

using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

/// A mesh with its materials: mass, energy, force and stiffness as functions of the displacement u
/// (3 num_nodes) [m].
///
/// Keeps the sparsity pattern and the slots of every element between calls; matrices are symmetric
/// and stored whole, `stiffness` and `stiffness_damping` in one pattern, so that their values
/// combine entry by entry. An empty vector stands for zero. Results do not depend on the number of
/// threads.
/// @throws InputError from all functions of u if its size is neither 0 nor 3 num_nodes
class ElasticBody {
 public:
  /// @param materials  one for each of mesh.material_names, in that order
  /// @throws InputError if their number disagrees, or E <= 0, rho <= 0, nu outside (-1, 0.5), a or
  /// b < 0, or an element is turned inside out
  ElasticBody(HexMesh mesh,
              std::vector<ElasticMaterial> materials,
              ConstitutiveModel model = ConstitutiveModel::NeoHookean);
  ~ElasticBody();
  ElasticBody(ElasticBody&&) noexcept;
  ElasticBody& operator=(ElasticBody&&) noexcept;

  [[nodiscard]] const HexMesh& mesh() const;
  [[nodiscard]] const std::vector<ElasticMaterial>& materials() const;
  [[nodiscard]] ConstitutiveModel model() const;

  /// Adds a weight at a point of the mesh to the mass matrix and to `gravity_force`.
  void add_point_mass(const MeshPoint& point, double mass_kg);
  struct PointMass {
    std::vector<int> nodes;
    Eigen::VectorXd weights;  ///< of the nodes [-]
    double mass_kg = 0.0;
  };
  [[nodiscard]] const std::vector<PointMass>& point_masses() const;

  /// Consistent mass matrix by the element's quadrature [kg]; it holds a third of the entries of a
  /// stiffness. Assembled when first asked for, as is the pattern of the matrices.
  [[nodiscard]] const SparseMatrix& mass() const;
  /// A += factor M for a matrix that `stiffness` or `stiffness_damping` returned, in its own
  /// pattern.
  /// @throws InputError for any other matrix
  void add_scaled_mass(double factor, SparseMatrix& A) const;
  /// Stored energy [J]; +infinity if an element is turned inside out.
  [[nodiscard]] double elastic_energy(const Eigen::VectorXd& u) const;
  /// Internal force, the gradient of the energy; external forces balance it at rest [N]. Not a
  /// number where `elastic_energy` is infinite.
  [[nodiscard]] Eigen::VectorXd internal_force(const Eigen::VectorXd& u) const;
  /// Tangent stiffness, the Hessian of the energy [N/m].
  [[nodiscard]] SparseMatrix stiffness(const Eigen::VectorXd& u) const;
  /// Tangent stiffness with each element scaled by its material's b: the stiffness part of the
  /// damping matrix [N s/m].
  [[nodiscard]] SparseMatrix stiffness_damping(const Eigen::VectorXd& u) const;
  /// K(u) w without assembling K [N].
  [[nodiscard]] Eigen::VectorXd stiffness_product(const Eigen::VectorXd& u,
                                                  const Eigen::VectorXd& w) const;
  /// Stiffness part of the damping force, sum over elements of b_e K_e(u) v, without assembling
  /// [N].
  [[nodiscard]] Eigen::VectorXd stiffness_damping_force(const Eigen::VectorXd& u,
                                                        const Eigen::VectorXd& v) const;
  /// sum of rho g N over the volume and of the point masses [N].
  [[nodiscard]] Eigen::VectorXd gravity_force(const Eigen::Vector3d& gravity_m_s2) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

/// Degrees of freedom that are free to move when others are held, and the maps to and from the full
/// vector.
class FreeDofs {
 public:
  /// Holds all three degrees of freedom of `held_nodes`.
  /// @throws InputError if a node does not exist
  FreeDofs(int num_nodes, const std::vector<int>& held_nodes);
  /// Holds single degrees of freedom, 3 node + axis.
  /// @throws InputError if one does not exist
  [[nodiscard]] static FreeDofs from_held_dofs(int num_nodes, const std::vector<int>& held_dofs);
  [[nodiscard]] int size() const { return static_cast<int>(m_full_from_free.size()); }
  [[nodiscard]] const std::vector<int>& full_from_free() const { return m_full_from_free; }
  [[nodiscard]] std::vector<int> held_dofs() const;  ///< ascending
  [[nodiscard]] Eigen::VectorXd restrict_vector(const Eigen::VectorXd& full) const;
  [[nodiscard]] Eigen::VectorXd expand_vector(
      const Eigen::VectorXd& free) const;  ///< held entries 0
  [[nodiscard]] SparseMatrix restrict_matrix(const SparseMatrix& full) const;

 private:
  explicit FreeDofs(const std::vector<char>& held);

  std::vector<int> m_free_from_full;  ///< -1 where held
  std::vector<int> m_full_from_free;
};

}  // namespace twang
