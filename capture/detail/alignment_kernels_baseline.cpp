// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled for every machine.
#define TWANG_KERNEL_NAMESPACE alignment_baseline
#include "capture/detail/alignment_kernels_impl.hpp"
