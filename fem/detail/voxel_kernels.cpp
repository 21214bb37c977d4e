// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/voxel_kernels.hpp"

namespace twang {

const VoxelKernels& voxel_kernels() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    return voxel_x86_64_v3::kernels();
  }
#endif
  return voxel_baseline::kernels();
}

}  // namespace twang
