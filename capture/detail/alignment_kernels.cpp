// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/alignment_kernels.hpp"

namespace twang::detail {

const AlignmentKernels& alignment_kernels() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    return alignment_x86_64_v3::kernels();
  }
#endif
  return alignment_baseline::kernels();
}

TemplateSample look_up(const TemplateCells& table, float u, float v) {
  return alignment_baseline::look_up_one(table, u, v);
}

}  // namespace twang::detail
