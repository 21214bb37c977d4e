// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/cell_grid.hpp"
#include "fem/detail/voxel_kernels.hpp"
#include "fem/elastic_body.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

namespace twang {

/// What keeps a mesh from being treated as cells of a regular grid, in a few words; empty if
/// nothing does.
[[nodiscard]] std::string voxel_fault(const HexMesh& mesh);

/// Lamé constants and masses of the cells for one combination of stiffness and mass; times volume
/// / 64, as the kernels want them.
template <class Real>
struct CellModuli {
  Eigen::Array<Real, Eigen::Dynamic, 1> mu, lambda, mass;  ///< empty where not needed
};

/// A voxel mesh as a regular grid. Vectors are (3 num_nodes), component by component along the
/// grid's own axes, the longest rows first; held degrees of freedom are 0.
class VoxelBody {
 public:
  /// @param body  without voxel_fault
  VoxelBody(const ElasticBody& body, const FreeDofs& free);

  [[nodiscard]] const CellGrid& grid() const { return m_grid; }
  [[nodiscard]] int size() const { return 3 * m_grid.num_nodes(); }
  [[nodiscard]] int num_nodes() const { return m_grid.num_nodes(); }
  [[nodiscard]] const std::vector<char>& held() const { return m_held; }
  /// Cells of one type have nearly the same matrix: one material, and as full but for a part in
  /// kFillSteps; right for a preconditioner.
  [[nodiscard]] int type_of_cell(int cell) const { return m_type_of_cell[cell]; }
  static constexpr double kFillSteps = 32.0;
  /// lambda over mu of the material nearest to incompressibility: 9 at nu = 0.45, 499 at 0.499 [-].
  [[nodiscard]] double incompressibility() const;

  [[nodiscard]] Eigen::VectorXd from_free(const Eigen::VectorXd& free) const;
  [[nodiscard]] Eigen::VectorXd to_free(const Eigen::VectorXd& own) const;
  [[nodiscard]] Eigen::VectorXd from_full(const Eigen::VectorXd& full) const;
  [[nodiscard]] Eigen::VectorXd to_full(const Eigen::VectorXd& own) const;

  template <class Real>
  [[nodiscard]] CellModuli<Real> moduli(const StiffnessCombination& of) const;
  /// y += scale A x, point masses left out.
  template <class Real>
  void add_product(const CellModuli<Real>& A, Real scale, const Real* x, Real* y) const;
  /// y += factor m N (N . x) of every point mass.
  void add_point_masses(double factor, const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  /// Of one cell of a type, held by nothing, (24 x 24), component by component.
  [[nodiscard]] Eigen::MatrixXd cell_matrix(const StiffnessCombination& of, int type) const;

 private:
  struct CellMaterial {
    double mu = 0.0, lambda = 0.0, density = 0.0, damping_b = 0.0;
  };
  struct PointMass {
    std::vector<int> nodes;  ///< of the grid
    Eigen::VectorXd weights;
    double mass_kg = 0.0;
  };
  void take_materials(const ElasticBody& body, const Eigen::Matrix3Xi& cells);
  template <class Real>
  [[nodiscard]] CellConstants<Real> constants(Real scale) const;

  std::array<int, 3> m_axis = {0, 1, 2};                  ///< of the mesh, for each of the grid
  Eigen::Vector3d m_cell_size = Eigen::Vector3d::Zero();  ///< along the grid's axes [m]
  bool m_enhanced = false;
  CellGrid m_grid;
  Eigen::ArrayXi m_material_of_cell;
  std::vector<CellMaterial> m_materials;
  Eigen::ArrayXd m_stiffness_fill;  ///< of each cell; empty: 1
  Eigen::ArrayXd m_mass_fill;
  Eigen::ArrayXi m_type_of_cell;
  std::vector<CellMaterial> m_types;
  Eigen::ArrayXi m_full_from_own;  ///< degree of freedom of the mesh for each of the grid
  Eigen::ArrayXi m_free_from_own;  ///< -1 where held
  std::vector<char> m_held;        ///< of each degree of freedom of the grid
  Eigen::ArrayXi m_held_dofs;
  std::vector<PointMass> m_point_masses;
  int m_num_free = 0;
};

}  // namespace twang
