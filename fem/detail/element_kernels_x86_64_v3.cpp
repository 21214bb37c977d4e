// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled for machines with AVX2 and FMA; see fem/CMakeLists.txt.
#define TWANG_KERNEL_NAMESPACE kernels_x86_64_v3
#include "fem/detail/element_kernels_impl.hpp"
