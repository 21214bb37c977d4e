// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled for machines with AVX2 and FMA; see fem/CMakeLists.txt.
#define TWANG_KERNEL_NAMESPACE voxel_x86_64_v3
#include "fem/detail/voxel_kernels_impl.hpp"
