// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled for machines with AVX2 and FMA; see capture/CMakeLists.txt.
#define TWANG_KERNEL_NAMESPACE alignment_x86_64_v3
#include "capture/detail/alignment_kernels_impl.hpp"
