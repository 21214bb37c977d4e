// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

namespace twang {

/// Fixes how many threads computations use from now on, so that their results repeat bit for bit
/// however busy the machine is.
///
/// Forces and products do not depend on the number of threads; a factorization does, in its last
/// digits. With 0, as many threads as are idle do the former and one the latter.
/// @param threads  0, or >= 1: as many for everything
/// @throws InputError if threads < 0
void fix_threads(int threads);

/// Calls work(first, last) for ranges that together are 0 to count, on several threads where there
/// are enough of them to repay it and the machine permits.
void for_each_range(int count, const std::function<void(int first, int last)>& work);

}  // namespace twang
