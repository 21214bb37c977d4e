// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cholmod.h>

namespace twang {

/// CHOLMOD's functions by the width of its indices: 32 bits hold factors of up to 2^31 entries (17
/// GB) and read an Eigen matrix in place, 64 bits hold all.
template <class Index>
struct CholmodCalls;

template <>
struct CholmodCalls<int> {
  static constexpr int itype = CHOLMOD_INT;
  static constexpr auto start = cholmod_start;
  static constexpr auto finish = cholmod_finish;
  static constexpr auto nested_dissection = cholmod_nested_dissection;
  static constexpr auto analyze = cholmod_analyze_p;
  static constexpr auto factorize = cholmod_factorize;
  static constexpr auto solve = cholmod_solve2;
  static constexpr auto free_factor = cholmod_free_factor;
  static constexpr auto free_dense = cholmod_free_dense;
};

template <>
struct CholmodCalls<SuiteSparse_long> {
  static constexpr int itype = CHOLMOD_LONG;
  static constexpr auto start = cholmod_l_start;
  static constexpr auto finish = cholmod_l_finish;
  static constexpr auto nested_dissection = cholmod_l_nested_dissection;
  static constexpr auto analyze = cholmod_l_analyze_p;
  static constexpr auto factorize = cholmod_l_factorize;
  static constexpr auto solve = cholmod_l_solve2;
  static constexpr auto free_factor = cholmod_l_free_factor;
  static constexpr auto free_dense = cholmod_l_free_dense;
};

}  // namespace twang
