// SPDX-License-Identifier: GPL-3.0-or-later
// Look-ups in a template's table, several at a time. Part of alignment_kernels_impl.hpp, in the
// namespace of its instruction set: see there.
#pragma once

#include "capture/detail/alignment_kernels.hpp"

#ifndef TWANG_KERNEL_NAMESPACE
#error "TWANG_KERNEL_NAMESPACE must be defined by the file that includes this"
#endif

namespace twang::detail::TWANG_KERNEL_NAMESPACE {
namespace {

// Pixels that are looked up together.
#ifdef __AVX2__
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif
typedef float Lanes __attribute__((vector_size(4 * kLanes)));
typedef float LooseLanes __attribute__((vector_size(4 * kLanes), aligned(4), may_alias));
typedef int IntLanes __attribute__((vector_size(4 * kLanes)));
typedef int LooseIntLanes __attribute__((vector_size(4 * kLanes), may_alias));
typedef short Cell __attribute__((vector_size(16), aligned(2), may_alias));
typedef short Words __attribute__((vector_size(4 * kLanes)));
static_assert(kAlignmentBlock % kLanes == 0);

inline Lanes load(const float* from) { return *reinterpret_cast<const LooseLanes*>(from); }
inline void store(float* to, Lanes values) { *reinterpret_cast<LooseLanes*>(to) = values; }

inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
inline Lanes square_root(Lanes values) {
#ifdef __AVX2__
  return __builtin_ia32_sqrtps256(values);
#else
  for (int lane = 0; lane < kLanes; ++lane) values[lane] = __builtin_sqrtf(values[lane]);
  return values;
#endif
}
inline Lanes bounded(Lanes value, Lanes low, Lanes high) {
  const Lanes raised = value > low ? value : low;
  return raised < high ? raised : high;
}

// In every 16 bytes: a0 b0 a1 b1 .., the first half of each or the last.
#ifdef __AVX2__
inline Words mix_first(Words a, Words b) {
  return __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 8, 24, 9, 25, 10, 26, 11, 27);
}
inline Words mix_last(Words a, Words b) {
  return __builtin_shufflevector(a, b, 4, 20, 5, 21, 6, 22, 7, 23, 12, 28, 13, 29, 14, 30, 15, 31);
}
inline IntLanes pair_first(IntLanes a, IntLanes b) {
  return __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
}
inline IntLanes pair_last(IntLanes a, IntLanes b) {
  return __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
}
#else
inline Words mix_first(Words a, Words b) {
  return __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11);
}
inline Words mix_last(Words a, Words b) {
  return __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
}
inline IntLanes pair_first(IntLanes a, IntLanes b) {
  return __builtin_shufflevector(a, b, 0, 4, 1, 5);
}
inline IntLanes pair_last(IntLanes a, IntLanes b) {
  return __builtin_shufflevector(a, b, 2, 6, 3, 7);
}
#endif

/// Where the numbers of a cell stand in the table.
inline IntLanes offset_of(const TemplateCells& table, IntLanes column, IntLanes row) {
  constexpr int kWithin = kCellPhases - 1;
  const IntLanes square = ((row & kWithin) << kCellPhaseBits) + (column & kWithin);
  const IntLanes line = square * table.part + (row >> kCellPhaseBits);
  return kCellNumbers * (line * table.part + (column >> kCellPhaseBits));
}

/// The cell of one lane; of eight lanes, that of the lane four on behind it.
inline Words cell_of(const CellNumber* cells, const int* offset) {
  const Cell near = *reinterpret_cast<const Cell*>(cells + offset[0]);
#ifdef __AVX2__
  const Cell far = *reinterpret_cast<const Cell*>(cells + offset[4]);
  return __builtin_shufflevector(near, far, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#else
  return near;
#endif
}

/// One number of each lane, and the next: times 2^16, as a number's bits stand in an integer's
/// upper half.
inline Lanes number(IntLanes pairs) {
  return __builtin_convertvector((IntLanes)mix_first(Words{}, (Words)pairs), Lanes);
}
inline Lanes next_number(IntLanes pairs) {
  return __builtin_convertvector((IntLanes)mix_last(Words{}, (Words)pairs), Lanes);
}
constexpr float kUpperHalf = 65536.0F;

/// Value and slopes, these by the cell's index.
struct SampledLanes {
  Lanes value, du, dv;
};

/// The second-order expansion about the nearest cell, at places given in cells.
/// @param even  where not null, set to how far from there the template does not change [cells]
inline SampledLanes expand(const TemplateCells& table,
                           Lanes column,
                           Lanes row,
                           Lanes* even = nullptr) {
  const Lanes zero = {};
  const Lanes last = zero + static_cast<float>(table.side - 1);
  column = bounded(column, zero, last);
  row = bounded(row, zero, last);
  const IntLanes i = __builtin_convertvector(column + 0.5F, IntLanes);
  const IntLanes j = __builtin_convertvector(row + 0.5F, IntLanes);
  alignas(IntLanes) int offset[kLanes];
  *reinterpret_cast<LooseIntLanes*>(offset) = offset_of(table, i, j);
  const Lanes x = column - __builtin_convertvector(i, Lanes);
  const Lanes y = row - __builtin_convertvector(j, Lanes);

  const Words a = cell_of(table.cells, offset);
  const Words b = cell_of(table.cells, offset + 1);
  const Words c = cell_of(table.cells, offset + 2);
  const Words d = cell_of(table.cells, offset + 3);
  const IntLanes ab = (IntLanes)mix_first(a, b), cd = (IntLanes)mix_first(c, d);
  const IntLanes ab_behind = (IntLanes)mix_last(a, b), cd_behind = (IntLanes)mix_last(c, d);
  const IntLanes zeroth = pair_first(ab, cd);
  const IntLanes mixed = pair_last(ab, cd);
  const IntLanes seconds = pair_first(ab_behind, cd_behind);
  const Lanes f = number(zeroth), f_i = next_number(zeroth);
  const Lanes f_j = number(mixed), f_ij = next_number(mixed);
  const Lanes f_ii = number(seconds), f_jj = next_number(seconds);
  if (even != nullptr) {
    *even = 1.0F / (kUpperHalf * kEvenScale) * number(pair_last(ab_behind, cd_behind));
  }
  const Lanes du = f_i + f_ii * x + f_ij * y;
  const Lanes dv = f_j + f_ij * x + f_jj * y;
  constexpr float kUnit = 1.0F / (kUpperHalf * kCellScale);
  return {kUnit * (f + 0.5F * ((f_i + du) * x + (f_j + dv) * y)), kUnit * du, kUnit * dv};
}

/// Whether all lanes of a comparison hold.
inline bool all(IntLanes holds) {
#ifdef __AVX2__
  return __builtin_ia32_movmskps256(reinterpret_cast<Lanes>(holds)) == 0xff;
#else
  return (holds[0] & holds[1] & holds[2] & holds[3]) != 0;
#endif
}

/// The template at `kLanes` pixels, averaged along the path.
inline void sample_lanes(const TemplateCells& table,
                         const MotionPath& path,
                         const ModelSamples& samples,
                         int at) {
  const Lanes zero = {};
  const Lanes weight = load(samples.weight + at);
  if (all(weight == zero)) {
    store(samples.value + at, zero + 1.0F);
    store(samples.ends + at, zero + 1.0F);
    store(samples.du + at, zero);
    store(samples.dv + at, zero);
    return;
  }
  const Lanes column = (load(samples.u + at) + table.middle) * table.per_unit;
  const Lanes row = (load(samples.v + at) + table.middle) * table.per_unit;
  const float along_u = path.u * table.per_unit;
  const float along_v = path.v * table.per_unit;
  const float half_path = 0.5F * __builtin_sqrtf(along_u * along_u + along_v * along_v) + 1.0F;
  Lanes even;
  SampledLanes sum = expand(table, column, row, &even);
  if (all((even > half_path) | (weight == zero))) {
    store(samples.value + at, sum.value);
    store(samples.ends + at, sum.value);
    store(samples.du + at, zero);
    store(samples.dv + at, zero);
    return;
  }
  const float per_sample = 1.0F / static_cast<float>(path.samples);
  for (int k = 1; 2 * k < path.samples; ++k) {
    const float s = static_cast<float>(k) * per_sample;
    const SampledLanes before = expand(table, column - s * along_u, row - s * along_v);
    const SampledLanes behind = expand(table, column + s * along_u, row + s * along_v);
    sum.value += before.value + behind.value;
    sum.du += before.du + behind.du;
    sum.dv += before.dv + behind.dv;
  }
  store(samples.value + at, per_sample * sum.value);
  store(samples.du + at, per_sample * table.per_unit * sum.du);
  store(samples.dv + at, per_sample * table.per_unit * sum.dv);
  if (path.ends) {
    const Lanes behind = expand(table, column + 0.5F * along_u, row + 0.5F * along_v).value;
    const Lanes before = expand(table, column - 0.5F * along_u, row - 0.5F * along_v).value;
    store(samples.ends + at, 0.5F * (behind + before));
  }
}

}  // namespace
}  // namespace twang::detail::TWANG_KERNEL_NAMESPACE
