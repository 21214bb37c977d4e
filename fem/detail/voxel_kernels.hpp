// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace twang {

/// What the cells of a grid have in common.
template <class Real>
struct CellConstants {
  Real per_half[3] = {};   ///< 2 / cell size along each axis [1/m]
  Real scale = Real(1.0);  ///< of what is added
};

/// Cells side by side along the grid's first axis, and the four rows of nodes at their edges: at
/// (second, third axis) = 00, 10, 01, 11.
template <class Real>
struct CellRow {
  int length = 0;            ///< cells; each edge has one node more
  const Real* x[3][4] = {};  ///< [component][edge], first node
  Real* y[3][4] = {};        ///< what is added to
  const Real* mu = nullptr;  ///< Lamé's constants times volume / 64, of each cell
  const Real* lambda = nullptr;
  const Real* mass = nullptr;  ///< of each cell, over 64
};

/// y += scale A x over a row of cells, A = K + M, K alone or M alone.
template <class Real>
struct RowProducts {
  using Product = void (*)(const CellConstants<Real>& constants, const CellRow<Real>& row);
  Product both = nullptr;
  Product stiffness = nullptr;
  Product mass = nullptr;
};

/// A row of cells that have matrices of their own, 24 x 24, symmetric, component by component (the
/// eight nodes' first, then their second ...), nodes with the first axis fastest.
struct DenseRow {
  int length = 0;
  const float* x[3][4] = {};
  float* y[3][4] = {};
  const int* type = nullptr;        ///< of each cell
  const float* matrices = nullptr;  ///< of each type
  float scale = 1.0F;
};

/// Products of voxel meshes, compiled for several instruction sets, chosen at run time.
///
/// On a box the trilinear functions 1, x, y, z, xy, yz, zx, xyz are orthogonal, and so stiffness
/// and mass fall apart into small blocks between them; sums and differences lead from nodes to
/// them and back. `enhanced` means hex8e: its internal modes take the shear of bending away and
/// leave the lateral strain free, and lambda does not see bilinear dilatation.
struct VoxelKernels {
  RowProducts<double> hex8_double, hex8e_double;
  RowProducts<float> hex8_float, hex8e_float;
  void (*dense)(const DenseRow& row) = nullptr;  ///< y += scale K x

  template <class Real>
  [[nodiscard]] const RowProducts<Real>& products(bool enhanced) const;
};
template <>
[[nodiscard]] inline const RowProducts<double>& VoxelKernels::products<double>(
    bool enhanced) const {
  return enhanced ? hex8e_double : hex8_double;
}
template <>
[[nodiscard]] inline const RowProducts<float>& VoxelKernels::products<float>(bool enhanced) const {
  return enhanced ? hex8e_float : hex8_float;
}

[[nodiscard]] const VoxelKernels& voxel_kernels();

namespace voxel_baseline {
[[nodiscard]] const VoxelKernels& kernels();
}
namespace voxel_x86_64_v3 {
[[nodiscard]] const VoxelKernels& kernels();
}

}  // namespace twang
