// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang {

/// Products with the matrices of a mesh of hex20 that are all the same box: one matrix for each
/// material serves all cells, a few dozen at a time. Vectors are
/// (3 num_nodes), component by component, nodes in the mesh's order.
class QuadraticCells {
 public:
  /// Keeps no reference.
  explicit QuadraticCells(const ElasticBody& body);

  /// A of each material's full cell.
  template <class Real>
  struct Matrices {
    using Dense = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
    std::vector<Dense> stiff;  ///< (60 x 60), scaled by a cell's stiffness fill; empty: none
    std::vector<Dense> mass;   ///< (60 x 60), scaled by its mass fill; empty: none, or in `stiff`
  };
  template <class Real>
  [[nodiscard]] Matrices<Real> matrices(const StiffnessCombination& of) const;

  /// y += scale A x without point masses; the sum does not depend on the number of threads.
  template <class Real>
  void add_product(const Matrices<Real>& A, Real scale, const Real* x, Real* y) const;

  /// The 3 x 3 blocks on the diagonal of A, (num_nodes x 6): 00 10 20 11 21 22.
  [[nodiscard]] Eigen::ArrayXXd diagonal_blocks(const Matrices<double>& A) const;

 private:
  struct Material {
    Eigen::MatrixXd stiffness;  ///< (60 x 60) [N/m]
    Eigen::MatrixXd mass;       ///< (60 x 60) [kg]
    double damping_b = 0.0;     ///< [s]
  };
  /// Cells of one material, side by side in memory, no two of a colour sharing a node.
  struct Batch {
    int first = 0;
    int count = 0;
    int material = 0;
  };
  template <class Real>
  void add_batch(
      const Matrices<Real>& A, const Batch& batch, Real scale, const Real* x, Real* y) const;

  int m_num_nodes = 0;
  std::vector<Material> m_materials;
  Eigen::MatrixXi m_nodes;          ///< (20 x num_cells), in the order of the batches
  Eigen::ArrayXd m_stiffness_fill;  ///< of each cell in that order; empty: 1
  Eigen::ArrayXd m_mass_fill;
  std::vector<std::vector<Batch>> m_colours;
};

}  // namespace twang
