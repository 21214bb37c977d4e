// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/alignment_kernels.hpp"

#include "capture/detail/alignment_workspace.hpp"
#include "capture/marker_template.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace twang::detail {
namespace {

// Odd, so that rows of pixels and blocks of them never fall together.
constexpr int kWidth = 37;
constexpr int kHeight = 41;
constexpr double kSize_px = 24.0;
constexpr double kBlur_px = 0.8;

/// A picture with some structure, and a marker that lies turned in it.
struct Scene {
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(kWidth * kHeight);
  AlignmentWindow window;
  MotionPath path{0.21F, -0.13F, 7, true};

  explicit Scene(bool round) {
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      pixels[i] = static_cast<std::uint8_t>(128.0 + 90.0 * std::sin(0.7 * static_cast<double>(i)));
    }
    window.pixels = pixels.data();
    window.stride = kWidth;
    window.width = kWidth;
    window.height = kHeight;
    window.first_x = -18.3F;
    window.first_y = -19.8F;
    const auto c = static_cast<float>(std::cos(0.2) / kSize_px);
    const auto s = static_cast<float>(std::sin(0.2) / kSize_px);
    const std::array<float, 4> turned = {c, s, -s, c};
    for (std::size_t i = 0; i < 4; ++i) {
      window.pattern_from_px[i] = turned[i];
      window.window_from_px[i] = turned[i];
    }
    window.round = round;
    window.reach = 0.6F;
    window.per_taper = static_cast<float>(kSize_px);
  }
};

class EveryMarker : public ::testing::TestWithParam<MarkerKind> {
 protected:
  MarkerTemplate marker() const {
    MarkerTemplate made(MarkerPattern(GetParam()), kSize_px, kBlur_px);
    made.mark_even();
    return made;
  }
};

TEST_P(EveryMarker, IsAveragedAlongThePath) {
  const MarkerTemplate marker = this->marker();
  const Scene scene(marker.is_round());
  AlignmentWorkspace workspace;
  workspace.reserve(kWidth * kHeight);
  const ModelSamples& samples = workspace.samples();
  alignment_kernels().sample(scene.window, marker.cells(), scene.path, samples);
  int num_weighted = 0;
  for (int i = 0; i < samples.room; ++i) {
    if (i >= kWidth * kHeight) {
      EXPECT_EQ(samples.weight[i], 0.0F);
    }
    if (samples.weight[i] == 0.0F) continue;
    ++num_weighted;
    const double u = samples.u[i];
    const double v = samples.v[i];
    double value = 0.0, du = 0.0;
    for (int k = -3; k <= 3; ++k) {
      const MarkerTemplate::Sample sample =
          marker.at(u + k / 7.0 * scene.path.u, v + k / 7.0 * scene.path.v);
      value += sample.value / 7.0;
      du += sample.du / 7.0;
    }
    const double ends = 0.5 * (marker.at(u + 0.5 * scene.path.u, v + 0.5 * scene.path.v).value +
                               marker.at(u - 0.5 * scene.path.u, v - 0.5 * scene.path.v).value);
    // The expansion about a cell errs by up to a thousandth; a place midway between two may take
    // either, as rounding has it. The steepest slope is about 12 a size.
    EXPECT_NEAR(samples.value[i], value, 5e-4);
    EXPECT_NEAR(samples.ends[i], ends, 2e-3);
    EXPECT_NEAR(samples.du[i], du, 0.05);
  }
  EXPECT_GT(num_weighted, 500);  // of the 1.2² 24² or a circle's part of them that the window holds
}

TEST_P(EveryMarker, IsSeenAlikeByAllInstructionSets) {
  const MarkerTemplate marker = this->marker();
  const Scene scene(marker.is_round());
  const MarkerLight light{40.0F, 150.0F, 5.0F, -7.0F};
  const AlignmentColumns columns{marker.has_turn() ? 4 : 3, true, 0.01F};
  const auto gram_of = [&](const AlignmentKernels& kernels) {
    AlignmentWorkspace workspace;
    workspace.reserve(kWidth * kHeight);
    kernels.sample(scene.window, marker.cells(), scene.path, workspace.samples());
    std::vector<double> gram(static_cast<std::size_t>((kMostColumns + 1) * (kMostColumns + 1)));
    kernels.accumulate(scene.window, workspace.samples(), light, columns, gram.data());
    return gram;
  };
  const auto plain = gram_of(alignment_baseline::kernels());
  const auto chosen = gram_of(alignment_kernels());
  const auto size = static_cast<std::size_t>(columns.size()) + 1;
  for (std::size_t r = 0; r < size; ++r) {
    for (std::size_t c = 0; c <= r; ++c) {
      const double scale = std::sqrt(plain[r * size + r] * plain[c * size + c]);
      // Sums in single precision, in another order.
      EXPECT_NEAR(chosen[r * size + c], plain[r * size + c], 1e-4 * scale) << r << ", " << c;
    }
  }
}

TEST_P(EveryMarker, GivesTheProductsOfItsLightAlone) {
  const MarkerTemplate marker = this->marker();
  const Scene scene(marker.is_round());
  const MarkerLight light{40.0F, 150.0F, 5.0F, -7.0F};
  AlignmentWorkspace workspace;
  workspace.reserve(kWidth * kHeight);
  alignment_kernels().sample(scene.window, marker.cells(), scene.path, workspace.samples());
  AlignmentColumns columns{1, false, 0.0F};
  const auto size = static_cast<std::size_t>(columns.size()) + 1;
  std::vector<double> all(size * size);
  alignment_kernels().accumulate(scene.window, workspace.samples(), light, columns, all.data());
  columns.light_only = true;
  std::vector<double> part(size * size);
  alignment_kernels().accumulate(scene.window, workspace.samples(), light, columns, part.data());
  for (std::size_t r = 0; r < size; ++r) {
    for (std::size_t c = 0; c <= r; ++c) {
      const double wanted = c >= size - 5 ? all[r * size + c] : 0.0;
      const double scale = std::sqrt(all[r * size + r] * all[c * size + c]);
      // The same sums, perhaps in another order.
      EXPECT_NEAR(part[r * size + c], wanted, 1e-5 * scale) << r << ", " << c;
    }
  }
}

TEST_P(EveryMarker, IsJudgedAsPixelByPixel) {
  const MarkerTemplate marker = this->marker();
  const Scene scene(marker.is_round());
  const MarkerLight light{40.0F, 150.0F, 5.0F, -7.0F};
  const JudgedPixels judged{0.7F, 9.0F, 110.0F};
  for (const AlignmentKernels& kernels : {alignment_baseline::kernels(), alignment_kernels()}) {
    AlignmentWorkspace workspace;
    workspace.reserve(kWidth * kHeight);
    const ModelSamples& samples = workspace.samples();
    float* r = workspace.residual();
    float* slope = workspace.square_slope();
    const AlignmentColumns columns{1, false, 0.0F};
    const std::array<double, kMostColumns> step{};
    kernels.sample(scene.window, marker.cells(), scene.path, samples);
    kernels.residuals(scene.window, samples, light, columns, step.data(), r, slope);
    const auto is_flat = [&](int i) {
      return samples.weight[i] >= judged.least_weight && slope[i] < judged.steep;
    };
    ResidualSums wanted;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      if (samples.weight[i] < judged.least_weight) continue;
      const double residual = r[i];
      const double grey = samples.grey[i] - judged.middle;
      wanted.count += 1.0, wanted.square += residual * residual;
      wanted.grey += grey, wanted.model += grey - residual;
      wanted.grey_grey += grey * grey, wanted.grey_model += grey * (grey - residual);
      wanted.model_model += (grey - residual) * (grey - residual);
      if (!is_flat(i)) continue;
      wanted.flat += 1.0, wanted.flat_square += residual * residual;
      if (i % kWidth > 0 && is_flat(i - 1)) {
        wanted.num_beside += 1.0, wanted.beside += residual * r[i - 1];
      }
      if (i >= kWidth && is_flat(i - kWidth)) {
        wanted.num_below += 1.0, wanted.below += residual * r[i - kWidth];
      }
    }
    const ResidualSums sums = kernels.sum_up(scene.window, samples, judged, r, slope);
    EXPECT_GT(wanted.flat, 100.0);
    EXPECT_LT(wanted.flat, wanted.count);
    EXPECT_EQ(sums.count, wanted.count);
    EXPECT_EQ(sums.flat, wanted.flat);
    EXPECT_EQ(sums.num_beside, wanted.num_beside);
    EXPECT_EQ(sums.num_below, wanted.num_below);
    // Rows are summed in single precision; signed terms cancel, so squares are the scale.
    const double close = 1e-5 * (wanted.square + wanted.grey_grey + wanted.model_model);
    EXPECT_NEAR(sums.square, wanted.square, close);
    EXPECT_NEAR(sums.grey, wanted.grey, close);
    EXPECT_NEAR(sums.model, wanted.model, close);
    EXPECT_NEAR(sums.grey_grey, wanted.grey_grey, close);
    EXPECT_NEAR(sums.model_model, wanted.model_model, close);
    EXPECT_NEAR(sums.grey_model, wanted.grey_model, close);
    EXPECT_NEAR(sums.flat_square, wanted.flat_square, close);
    EXPECT_NEAR(sums.beside, wanted.beside, close);
    EXPECT_NEAR(sums.below, wanted.below, close);
  }
}

INSTANTIATE_TEST_SUITE_P(AlignmentKernels,
                         EveryMarker,
                         ::testing::Values(MarkerKind::Cross,
                                           MarkerKind::Dot,
                                           MarkerKind::Checker));

}  // namespace
}  // namespace twang::detail
