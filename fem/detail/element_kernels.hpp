// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/constitutive.hpp"
#include "fem/hexahedron.hpp"

namespace twang {

/// Elements worked on at once, one in each lane of a vector.
inline constexpr int kLanes = 4;

/// Shape gradients dN/dx and weights w det(dx/dxi) at the quadrature points of a batch of elements.
/// Congruent elements share one table; others have a lane each.
struct BatchGeometry {
  bool congruent = true;
  /// [point][node][xyz], with [lane] unless congruent; internal modes behind the nodes [1/m]
  const double* gradients = nullptr;
  const double* weights = nullptr;  ///< [point], with [lane] unless congruent [m³]
};

/// kLanes elements of one kind and constitutive model.
struct ElementBatch {
  BatchGeometry geometry;
  const double* mu = nullptr;      ///< [lane], Lamé constants [Pa]
  const double* lambda = nullptr;  ///< [lane] [Pa]
  const double* u = nullptr;       ///< [node][xyz][lane], displacement [m]
  const double* w = nullptr;       ///< the same for the vector of a product
};

/// What is computed of a batch; compiled for several instruction sets, chosen at run time.
struct ElementKernels {
  using Kernel = void (*)(const ElementBatch& batch, double* result);
  Kernel energy = nullptr;   ///< [lane], +infinity where inside out (neo-Hookean) [J]
  Kernel force = nullptr;    ///< [node][xyz][lane] [N]
  Kernel product = nullptr;  ///< K(u) w, [node][xyz][lane]
  /// [pair][column][row][lane] for node pairs (a, b <= a) in the order (0,0) (1,0) (1,1) (2,0) ...;
  /// the row belongs to a, the column to b [N/m].
  Kernel tangent = nullptr;
};
[[nodiscard]] ElementKernels select_kernels(ElementKind kind, ConstitutiveModel model);

namespace kernels_baseline {
[[nodiscard]] ElementKernels kernels(ElementKind kind, ConstitutiveModel model);
}
namespace kernels_x86_64_v3 {
[[nodiscard]] ElementKernels kernels(ElementKind kind, ConstitutiveModel model);
}

}  // namespace twang
