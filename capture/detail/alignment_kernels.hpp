// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>

namespace twang::detail {

/// Numbers a cell of a template's table: the value f and its derivatives f_i, f_j, f_ij, f_ii, f_jj
/// by the cell's column i and row j, all times kCellScale; how far from there the template does not
/// change, in cells times kEvenScale; one to fill up. A table is read from all over at every
/// alignment: the smaller it is, the sooner.
inline constexpr int kCellNumbers = 8;
inline constexpr float kCellScale = 16384.0F;
inline constexpr float kEvenScale = 64.0F;
using CellNumber = std::int16_t;

/// Cells about a pixel apart lie side by side, so that neighbouring pixels look up neighbouring
/// memory: of every fourth column and row, from each of the first four on, there is a square of its
/// own; row after row of squares, and in each row after row of cells.
inline constexpr int kCellPhaseBits = 2;
inline constexpr int kCellPhases = 1 << kCellPhaseBits;

/// A template's table.
struct TemplateCells {
  const CellNumber* cells = nullptr;  ///< (kCellPhases² squares x part² cells x kCellNumbers)
  int side = 0;                       ///< columns and rows of cells
  int part = 0;                       ///< of these in one square: side / kCellPhases, rounded up
  float per_unit = 0.0F;              ///< cells a unit of the pattern
  float middle = 0.0F;                ///< half the side of the sampled square [units]
};

/// A rectangle of pixels around a marker, and how the marker lies in it.
struct AlignmentWindow {
  const std::uint8_t* pixels = nullptr;  ///< of the upper left one
  std::ptrdiff_t stride = 0;             ///< bytes from one row to the next
  int width = 0;
  int height = 0;
  float first_x = 0.0F, first_y = 0.0F;  ///< offset of that pixel from the marker's centre [px]
  float pattern_from_px[4] = {};         ///< row after row [1/px]
  float window_from_px[4] = {};          ///< the same, as the marker was at the start [1/px]
  bool round = false;
  float reach = 0.0F;      ///< from the centre to the window's edge [units]
  float per_taper = 0.0F;  ///< 1 over the width in which the weight falls to 0 [1/units]
};

/// The path of the marker's motion during the exposure, in units of the pattern.
struct MotionPath {
  float u = 0.0F, v = 0.0F;
  int samples = 1;
  bool ends = false;  ///< the template at the path's ends is wanted too
};

/// What is known of each pixel of a window: arrays of `room` floats, a multiple of kAlignmentBlock.
struct ModelSamples {
  float* weight = nullptr;  ///< square root of the weight; 0 beyond the marker and its rim
  float* grey = nullptr;    ///< of the picture
  float* x = nullptr;       ///< offset from the marker's centre [px]
  float* y = nullptr;
  float* u = nullptr;  ///< the same in units of the pattern
  float* v = nullptr;
  float* value = nullptr;  ///< of the template, averaged along the path
  float* du = nullptr;
  float* dv = nullptr;
  float* ends = nullptr;  ///< mean of the template at the path's two ends
  int room = 0;
};
inline constexpr int kAlignmentBlock = 256;

/// Picture = ink + (contrast + slope_u u + slope_v v) value.
struct MarkerLight {
  float ink = 0.0F, contrast = 0.0F, slope_u = 0.0F, slope_v = 0.0F;
};

/// Which derivatives are wanted: position 2, shape 0, 1, 3 or 4, motion 0 or 1, light 4.
struct AlignmentColumns {
  int num_shape = 0;
  bool motion = false;
  float per_motion = 0.0F;  ///< d model / d (squared length of the path) = this * gain * (ends −
                            ///< value) [1/px²]
  bool light_only = false;  ///< only the products of the last five columns are wanted
  [[nodiscard]] int size() const { return 6 + num_shape + (motion ? 1 : 0); }
};
inline constexpr int kMostColumns = 11;

/// Which pixels are judged.
struct JudgedPixels {
  float least_weight = 0.0F;  ///< root of the weight from which a pixel counts
  float steep = 0.0F;         ///< squared slope from which it is not flat [grey levels²/px²]
  float middle = 0.0F;        ///< taken off picture and model before they are squared [grey levels]
};

/// Sums over the pixels that count, picture and model counted from `JudgedPixels::middle`; and over
/// the flat ones among them, by themselves and in pairs side by side and one below the other.
struct ResidualSums {
  double count = 0.0, square = 0.0;  ///< of residuals
  double grey = 0.0, model = 0.0;
  double grey_grey = 0.0, model_model = 0.0, grey_model = 0.0;
  double flat = 0.0, flat_square = 0.0;
  double beside = 0.0, num_beside = 0.0;  ///< products of two residuals
  double below = 0.0, num_below = 0.0;
};

/// The inner loops of the alignment; compiled for several instruction sets, chosen at run time.
struct AlignmentKernels {
  /// Fills all arrays; pixels beyond the window's own, up to `room`, get no weight.
  void (*sample)(const AlignmentWindow& window,
                 const TemplateCells& cells,
                 const MotionPath& path,
                 const ModelSamples& samples);
  /// Adds JᵀJ, Jᵀr and rᵀr, weighted, of residual r = picture − model and Jacobian J of the model
  /// to the lower triangle of `gram`, row after row ((size + 1) x (size + 1)), r being the last.
  void (*accumulate)(const AlignmentWindow& window,
                     const ModelSamples& samples,
                     const MarkerLight& light,
                     const AlignmentColumns& columns,
                     double* gram);
  /// Residuals r − J step, without weight, and the squared slope of the model [grey levels/px].
  void (*residuals)(const AlignmentWindow& window,
                    const ModelSamples& samples,
                    const MarkerLight& light,
                    const AlignmentColumns& columns,
                    const double* step,
                    float* residual,
                    float* square_slope);
  /// Sums of such residuals.
  ResidualSums (*sum_up)(const AlignmentWindow& window,
                         const ModelSamples& samples,
                         const JudgedPixels& judged,
                         const float* residual,
                         const float* square_slope);
};
[[nodiscard]] const AlignmentKernels& alignment_kernels();

/// One sample of a template: its value and slopes by u and v.
struct TemplateSample {
  float value, du, dv;
};
[[nodiscard]] TemplateSample look_up(const TemplateCells& table, float u, float v);

namespace alignment_baseline {
[[nodiscard]] const AlignmentKernels& kernels();
[[nodiscard]] TemplateSample look_up_one(const TemplateCells& table, float u, float v);
}  // namespace alignment_baseline
namespace alignment_x86_64_v3 {
[[nodiscard]] const AlignmentKernels& kernels();
[[nodiscard]] TemplateSample look_up_one(const TemplateCells& table, float u, float v);
}  // namespace alignment_x86_64_v3

}  // namespace twang::detail
