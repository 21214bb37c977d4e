// SPDX-License-Identifier: GPL-3.0-or-later
// The inner loops of the alignment, in a namespace of their own for each instruction set. No other
// header's inline functions are used here: compiled for one machine they could end up on another.
#include "capture/detail/alignment_kernels.hpp"
#include "capture/detail/residual_sums_impl.hpp"
#include "capture/detail/template_lookup_impl.hpp"

#ifndef TWANG_KERNEL_NAMESPACE
#error "TWANG_KERNEL_NAMESPACE must be defined by the file that includes this"
#endif

namespace twang::detail::TWANG_KERNEL_NAMESPACE {
namespace {

constexpr int kBlock = kAlignmentBlock;

/// Brightness and place of each pixel. Those beyond the window's own lie in its first corner.
inline void take_pixels(const AlignmentWindow& window, const ModelSamples& samples) {
  for (int row = 0; row < window.height; ++row) {
    __builtin_prefetch(window.pixels + row * window.stride);
    __builtin_prefetch(window.pixels + row * window.stride + window.width - 1);
  }
  for (int row = 0; row < window.height; ++row) {
    const int start = row * window.width;
    const std::uint8_t* pixels = window.pixels + row * window.stride;
    const float y = window.first_y + static_cast<float>(row);
#pragma omp simd
    for (int i = 0; i < window.width; ++i) {
      samples.grey[start + i] = static_cast<float>(pixels[i]);
      samples.x[start + i] = window.first_x + static_cast<float>(i);
      samples.y[start + i] = y;
    }
  }
  for (int i = window.width * window.height; i < samples.room; ++i) {
    samples.grey[i] = 0.0F;
    samples.x[i] = window.first_x;
    samples.y[i] = window.first_y;
  }
}

/// Where on the pattern each pixel lies, and its weight.
inline void place_pixels(const AlignmentWindow& window, const ModelSamples& samples) {
  const float* a = window.pattern_from_px;
  const float* b = window.window_from_px;
  const Lanes zero = {};
  for (int i = 0; i < samples.room; i += kLanes) {
    const Lanes x = load(samples.x + i);
    const Lanes y = load(samples.y + i);
    store(samples.u + i, a[0] * x + a[1] * y);
    store(samples.v + i, a[2] * x + a[3] * y);
    const Lanes p = b[0] * x + b[1] * y;
    const Lanes q = b[2] * x + b[3] * y;
    const Lanes square = window.round ? p * p + q * q : larger(p * p, q * q);
    const Lanes within = (window.reach - square_root(square)) * window.per_taper;
    store(samples.weight + i, square_root(bounded(within, zero, zero + 1.0F)));
  }
  for (int i = window.width * window.height; i < samples.room; ++i) samples.weight[i] = 0.0F;
}

void sample(const AlignmentWindow& window,
            const TemplateCells& table,
            const MotionPath& path,
            const ModelSamples& samples) {
  take_pixels(window, samples);
  place_pixels(window, samples);
  for (int i = 0; i < samples.room; i += kLanes) sample_lanes(table, path, samples, i);
}

/// Those by the light and, last, the residual, of one block of pixels; not weighted.
inline void fill_light(const ModelSamples& samples,
                       const MarkerLight& light,
                       int start,
                       float (*columns)[kBlock]) {
  const float* value = samples.value + start;
  const float* u = samples.u + start;
  const float* v = samples.v + start;
  for (int i = 0; i < kBlock; ++i) {
    const float gain = light.contrast + light.slope_u * u[i] + light.slope_v * v[i];
    columns[0][i] = 1.0F;
    columns[1][i] = value[i];
    columns[2][i] = u[i] * value[i];
    columns[3][i] = v[i] * value[i];
    columns[4][i] = samples.grey[start + i] - (light.ink + gain * value[i]);
  }
}

/// Columns of the Jacobian and, last, the residual, of one block of pixels; not weighted.
inline void fill_columns(const AlignmentWindow& window,
                         const ModelSamples& samples,
                         const MarkerLight& light,
                         const AlignmentColumns& layout,
                         int start,
                         float (*columns)[kBlock]) {
  const float* a = window.pattern_from_px;
  const float* value = samples.value + start;
  const float* u = samples.u + start;
  const float* v = samples.v + start;
  const float* x = samples.x + start;
  const float* y = samples.y + start;
  const int num_shape = layout.num_shape;
  fill_light(samples, light, start, columns + layout.size() - 4);
  for (int i = 0; i < kBlock; ++i) {
    const float gain = light.contrast + light.slope_u * u[i] + light.slope_v * v[i];
    const float by_u = gain * samples.du[start + i] + light.slope_u * value[i];
    const float by_v = gain * samples.dv[start + i] + light.slope_v * value[i];
    columns[0][i] = -(by_u * a[0] + by_v * a[2]);
    columns[1][i] = -(by_u * a[1] + by_v * a[3]);
  }
  if (num_shape == 1) {
    for (int i = 0; i < kBlock; ++i) columns[2][i] = columns[0][i] * y[i] - columns[1][i] * x[i];
  } else if (num_shape >= 3) {
    for (int i = 0; i < kBlock; ++i) {
      columns[2][i] = columns[0][i] * x[i];
      columns[3][i] = columns[1][i] * y[i];
      const float skew = columns[1][i] * x[i];
      columns[4][i] = columns[0][i] * y[i] + (num_shape == 3 ? skew : 0.0F);
      if (num_shape == 4) columns[5][i] = skew;
    }
  }
  if (layout.motion) {
    float* by_motion = columns[2 + num_shape];
    for (int i = 0; i < kBlock; ++i) {
      const float gain = light.contrast + light.slope_u * u[i] + light.slope_v * v[i];
      by_motion[i] = layout.per_motion * gain * (samples.ends[start + i] - value[i]);
    }
  }
}

/// Adds the products of two columns with four to the lower triangle.
inline void add_products(const float (*columns)[kBlock], int r, int c, int size, double* gram) {
  Lanes sums[2][4] = {};
  for (int i = 0; i < kBlock; i += kLanes) {
    const Lanes left[2] = {load(columns[r] + i), load(columns[r + 1] + i)};
    for (int k = 0; k < 4; ++k) {
      const Lanes right = load(columns[c + k] + i);
      sums[0][k] += left[0] * right;
      sums[1][k] += left[1] * right;
    }
  }
  for (int row = r; row < r + 2 && row < size; ++row) {
    for (int k = 0; k < 4 && c + k <= row; ++k) {
      float sum = 0.0F;
      for (int lane = 0; lane < kLanes; ++lane) sum += sums[row - r][k][lane];
      gram[row * size + c + k] += static_cast<double>(sum);
    }
  }
}

void accumulate(const AlignmentWindow& window,
                const ModelSamples& samples,
                const MarkerLight& light,
                const AlignmentColumns& layout,
                double* gram) {
  const int size = layout.size() + 1;
  const int first = layout.light_only ? layout.size() - 4 : 0;
  // Four more of zeros: products are taken of two by four columns at a time.
  alignas(32) float columns[kMostColumns + 1 + 4][kBlock];
  for (int c = size; c < size + 4; ++c) {
    for (int i = 0; i < kBlock; ++i) columns[c][i] = 0.0F;
  }
  for (int start = 0; start < samples.room; start += kBlock) {
    if (layout.light_only) {
      fill_light(samples, light, start, columns + first);
    } else {
      fill_columns(window, samples, light, layout, start, columns);
    }
    const float* weight = samples.weight + start;
    for (int c = first; c < size; ++c) {
      for (int i = 0; i < kBlock; ++i) columns[c][i] *= weight[i];
    }
    for (int r = first; r < size; r += 2) {
      for (int c = first; c <= r + 1; c += 4) add_products(columns, r, c, size, gram);
    }
  }
}

void residuals(const AlignmentWindow& window,
               const ModelSamples& samples,
               const MarkerLight& light,
               const AlignmentColumns& layout,
               const double* step,
               float* residual,
               float* square_slope) {
  const int size = layout.size();
  alignas(32) float columns[kMostColumns + 1][kBlock];
  for (int start = 0; start < samples.room; start += kBlock) {
    fill_columns(window, samples, light, layout, start, columns);
    for (int i = 0; i < kBlock; ++i) {
      square_slope[start + i] = columns[0][i] * columns[0][i] + columns[1][i] * columns[1][i];
      residual[start + i] = columns[size][i];
    }
    for (int c = 0; c < size; ++c) {
      const auto by = static_cast<float>(step[c]);
      for (int i = 0; i < kBlock; ++i) residual[start + i] -= by * columns[c][i];
    }
  }
}

}  // namespace

TemplateSample look_up_one(const TemplateCells& table, float u, float v) {
  const Lanes zero = {};
  const SampledLanes sample = expand(table,
                                     zero + (u + table.middle) * table.per_unit,
                                     zero + (v + table.middle) * table.per_unit);
  return {sample.value[0], table.per_unit * sample.du[0], table.per_unit * sample.dv[0]};
}

const AlignmentKernels& kernels() {
  static constexpr AlignmentKernels kKernels{sample, accumulate, residuals, sum_up};
  return kKernels;
}

}  // namespace twang::detail::TWANG_KERNEL_NAMESPACE
