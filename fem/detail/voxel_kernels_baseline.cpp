// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled for every machine.
#define TWANG_KERNEL_NAMESPACE voxel_baseline
#include "fem/detail/voxel_kernels_impl.hpp"
