// SPDX-License-Identifier: GPL-3.0-or-later
// Which kernel belongs to which element; part of element_kernels_impl.hpp, which includes it inside
// its namespace.
#include "fem/detail/enhanced_kernels_impl.hpp"

template <class Element, class Model>
ElementKernels kernels_of() {
  return {
      [](const ElementBatch& batch, double* result) {
        if (batch.geometry.congruent) return energy_kernel<Element, Model, true>(batch, result);
        energy_kernel<Element, Model, false>(batch, result);
      },
      [](const ElementBatch& batch, double* result) {
        if (batch.geometry.congruent) return force_kernel<Element, Model, true>(batch, result);
        force_kernel<Element, Model, false>(batch, result);
      },
      [](const ElementBatch& batch, double* result) {
        if (batch.geometry.congruent) return product_kernel<Element, Model, true>(batch, result);
        product_kernel<Element, Model, false>(batch, result);
      },
      [](const ElementBatch& batch, double* result) {
        if (batch.geometry.congruent) return tangent_kernel<Element, Model, true>(batch, result);
        tangent_kernel<Element, Model, false>(batch, result);
      },
  };
}

template <class Element, class Model>
ElementKernels all_kernels_of() {
  if constexpr (Element::nodes == Hex8e::nodes) return condensed_kernels_of<Model>();
  return kernels_of<Element, Model>();
}

template <class Element>
ElementKernels kernels_of(ConstitutiveModel model) {
  switch (model) {
    case ConstitutiveModel::NeoHookean:
      return all_kernels_of<Element, NeoHookean>();
    case ConstitutiveModel::SaintVenantKirchhoff:
      return all_kernels_of<Element, SaintVenantKirchhoff>();
    case ConstitutiveModel::Linear:
      break;
  }
  return all_kernels_of<Element, Linear>();
}
