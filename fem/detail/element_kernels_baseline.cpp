// SPDX-License-Identifier: GPL-3.0-or-later
#define TWANG_KERNEL_NAMESPACE kernels_baseline
#include "fem/detail/element_kernels_impl.hpp"
