// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/element_kernels.hpp"
#include "fem/hex_mesh.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang {

/// Where an element's nodes are, (3 x nodes) [m].
[[nodiscard]] Eigen::Matrix3Xd positions_of(const HexMesh& mesh, int element);

/// Shape gradients and weights of a mesh's elements at their quadrature points, kept for batches of
/// kLanes consecutive elements: one table if all elements are congruent (a voxel mesh), else one
/// for each batch.
class ElementGeometry {
 public:
  /// @throws InputError if an element is turned inside out or refers to a node that does not exist
  explicit ElementGeometry(const HexMesh& mesh);

  [[nodiscard]] bool congruent() const { return m_congruent; }
  [[nodiscard]] int num_batches() const { return m_num_batches; }
  [[nodiscard]] BatchGeometry batch(int index) const;
  /// integral of N_a N_b over an element, (nodes x nodes) [m³]
  [[nodiscard]] Eigen::MatrixXd shape_products(int element) const;

 private:
  [[nodiscard]] double weight(int element, int point) const;

  ElementKind m_kind;
  bool m_congruent = true;
  int m_num_batches = 0;
  std::vector<double> m_gradients;
  std::vector<double> m_weights;
};

}  // namespace twang
