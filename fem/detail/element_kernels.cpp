// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/element_kernels.hpp"

namespace twang {

ElementKernels select_kernels(ElementKind kind, ConstitutiveModel model) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    return kernels_x86_64_v3::kernels(kind, model);
  }
#endif
  return kernels_baseline::kernels(kind, model);
}

}  // namespace twang
