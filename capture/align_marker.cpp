// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/align_marker.hpp"

#include "capture/detail/alignment_kernels.hpp"
#include "capture/detail/alignment_workspace.hpp"
#include "capture/detail/flat_noise.hpp"
#include "core/constants.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace twang {
namespace {

using detail::alignment_kernels;
using detail::AlignmentColumns;
using detail::AlignmentKernels;
using detail::AlignmentWindow;
using detail::AlignmentWorkspace;
using detail::flat_variance;
using detail::kMostColumns;
using detail::MarkerLight;
using detail::ResidualSums;

constexpr int kMostParameters = detail::kMostColumns;
constexpr int kMostIterations = 25;
// An alignment of a marker of known size that will come to its end has small steps by then, that is
// below kNear_px; of a marker that is not there, or blurred otherwise, it wanders about.
constexpr int kSettled = 8;
constexpr double kConverged_px = 1e-3;  // last step
// Where the size is known, convergence is all but quadratic.
constexpr double kAlmostThere_px = 0.01;
constexpr double kLargestStep = 0.2;     // of the position, in marker sizes
constexpr double kLargestStretch = 0.1;  // of the shape, per iteration
// A path of motion that grows beyond so many sizes, and so many times what it was at the start, has
// lost the marker; each further step would be dear.
constexpr double kLongestPath = 2.0;
constexpr double kMostPathGrowth = 4.0;
// The rim of paper that is used, beyond the marker: as far as pixel and usual blurs reach, and
// within the quarter of the size that a paper square of 1.5 sizes leaves. The same for all blurs,
// so that their residuals can be compared.
constexpr double kLeastRim = 0.075;
constexpr double kWidestRim = 0.22;
constexpr double kRim_px = 2.0;
constexpr double kTaper_px = 1.0;
// Slope below which a pixel lies on plain ink or paper [contrasts/px].
constexpr double kFlat = 0.02;
constexpr double kFewestFlat = 40.0;
constexpr float kCounts = 0.7F;        // root of the weight of a pixel that is judged
constexpr double kSteadyLight = 0.05;  // of the contrast: its last step
// Between samples of the path of motion, in standard deviations of lens and pixel: the ripple that
// is left on an edge, 2 exp(−2π²/spacing²), is under 1 % of one sample's share.
constexpr double kPathSpacing = 1.9;
// On the way there the path is sampled so many times as coarsely, until steps are shorter than
// this.
constexpr double kRoughly = 2.0;
constexpr double kNear_px = 0.3;
constexpr double kPixelVariance_px2 = 1.0 / 12.0;
// Between paper and ink; with less there is nothing to be seen [grey levels].
constexpr double kLeastContrast = 1.0;
// Of the pixels that the marker should cover, this part must lie in the picture.
constexpr double kLeastCover = 0.9;

using Parameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostParameters, 1>;
using NormalMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostParameters, kMostParameters>;

/// A rotation, anticlockwise as seen where y points down.
Eigen::Matrix2d turned(double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return (Eigen::Matrix2d() << c, s, -s, c).finished();
}

/// Which parameter stands where in a row of the Jacobian; -1: not fitted.
struct Layout {
  int shape = -1;
  int num_shape = 0;
  int motion = -1;
  int light = 2;  // ink, contrast, two slopes
  int size = 6;

  Layout(const MarkerTemplate& marker, const AlignOptions& options) {
    int next = 2;
    if (options.fit_shape) {
      num_shape = marker.has_turn() ? 4 : 3;
    } else if (options.fit_turn && marker.has_turn()) {
      num_shape = 1;
    }
    if (num_shape > 0) shape = std::exchange(next, next + num_shape);
    if (options.fit_motion) motion = next++;
    light = next;
    size = next + 4;
  }
};

/// Kept from one alignment to the next: arrays of that size are dear to have and to give back.
AlignmentWorkspace& workspace_of_thread() {
  thread_local AlignmentWorkspace workspace;
  return workspace;
}

/// The rectangle of pixels that a marker's window can touch, cut to the picture.
class Alignment {
 public:
  Alignment(const LumaFrame& frame,
            const MarkerTemplate& marker,
            const MarkerPlacement& start,
            const AlignOptions& options)
      : m_frame(frame), m_marker(marker), m_options(options), m_layout(marker, options) {
    m_result.placement = start;
    m_window_shape = start.px_from_pattern;
    m_rim = marker.has_rim() ? std::clamp(kRim_px / marker.size_px(), kLeastRim, kWidestRim) : 0.0;
    m_taper = kTaper_px / marker.size_px();
  }

  MarkerAlignment run();

 private:
  void place_window();
  bool sample_model();
  void accumulate(bool light_only = false);
  void find_light();
  [[nodiscard]] bool covered() const;
  [[nodiscard]] bool solve(Parameters& delta, double& moved_px, bool& whole) const;
  void apply(const Parameters& delta);
  void judge(const Parameters& step);
  [[nodiscard]] MarkerLight light() const;
  [[nodiscard]] AlignmentColumns columns() const;

  const LumaFrame& m_frame;
  const MarkerTemplate& m_marker;
  const AlignOptions& m_options;
  const AlignmentKernels& m_kernels = alignment_kernels();
  Layout m_layout;
  MarkerAlignment m_result;
  double m_rim = 0.0;
  double m_taper = 0.0;
  Eigen::Matrix2d m_window_shape;  // px from the window's units, as the marker was at the start
  AlignmentWindow m_window;
  AlignmentWorkspace& m_workspace = workspace_of_thread();
  Eigen::Vector4d m_light = Eigen::Vector4d::Zero();  // ink, contrast, slopes
  NormalMatrix m_normal;
  Parameters m_gradient;
  double m_turn = 0.0;
  bool m_rough = false;  // the path's sampling
};

void row_major(const Eigen::Matrix2d& matrix, float (&values)[4]) {
  for (int i = 0; i < 4; ++i) values[i] = static_cast<float>(matrix(i / 2, i % 2));
}

/// The window's rectangle about the present position, within the picture. The window keeps the
/// shape the marker had at the start: residuals of different shapes are then comparable.
void Alignment::place_window() {
  const MarkerPlacement& placement = m_result.placement;
  const Eigen::Vector2d& at = placement.position_px;
  const Eigen::Vector2d reach = (0.5 + m_rim) * m_window_shape.cwiseAbs().rowwise().sum();
  const int x0 = std::max(0, static_cast<int>(std::ceil(at.x() - reach.x())));
  const int x1 = std::min(m_frame.width_px, static_cast<int>(std::floor(at.x() + reach.x())) + 1);
  const int y0 = std::max(0, static_cast<int>(std::ceil(at.y() - reach.y())));
  const int y1 = std::min(m_frame.height_px, static_cast<int>(std::floor(at.y() + reach.y())) + 1);
  m_window.width = std::max(0, x1 - x0);
  m_window.height = std::max(0, y1 - y0);
  m_window.stride = m_frame.stride;
  m_window.pixels = m_frame.pixels + y0 * m_frame.stride + x0;
  m_window.first_x = static_cast<float>(x0 - at.x());
  m_window.first_y = static_cast<float>(y0 - at.y());
  row_major(placement.px_from_pattern.inverse(), m_window.pattern_from_px);
  row_major(m_window_shape.inverse(), m_window.window_from_px);
  m_window.round = m_marker.is_round();
  m_window.reach = static_cast<float>(0.5 + m_rim);
  m_window.per_taper = static_cast<float>(1.0 / m_taper);
}

/// The template at the present placement, averaged along the path of motion; false if nothing of
/// the marker is in the picture.
bool Alignment::sample_model() {
  place_window();
  if (m_window.width == 0 || m_window.height == 0) return false;
  const MarkerPlacement& placement = m_result.placement;
  const Eigen::Vector2d path = placement.px_from_pattern.inverse() * placement.motion_px;
  const double blur_px = std::sqrt(m_marker.blur_px() * m_marker.blur_px() + kPixelVariance_px2);
  const double spacing_px = (m_rough ? kRoughly : 1.0) * std::max(1.0, kPathSpacing * blur_px);
  m_workspace.reserve(m_window.width * m_window.height);
  m_kernels.sample(
      m_window,
      m_marker.cells(),
      {static_cast<float>(path.x()),
       static_cast<float>(path.y()),
       1 + 2 * static_cast<int>(std::ceil(0.5 * placement.motion_px.norm() / spacing_px)),
       m_layout.motion >= 0},
      m_workspace.samples());
  return true;
}

/// Whether enough of the marker is in the picture. The squared column of ones says how much.
bool Alignment::covered() const {
  const double total_weight = m_normal(m_layout.light, m_layout.light);
  const double side = 1.0 + 2.0 * m_rim - m_taper;
  const double expected = (m_marker.is_round() ? kPi / 4.0 : 1.0) * side * side *
                          std::abs(m_window_shape.determinant());
  return total_weight >= kLeastCover * expected && total_weight > 2.0 * m_layout.size;
}

MarkerLight Alignment::light() const {
  const Eigen::Vector4f value = m_light.cast<float>();
  return {value[0], value[1], value[2], value[3]};
}

/// The derivative by the squared length L² of the path: d/dL of the mean over it is
/// (mean of its ends − mean) / L.
AlignmentColumns Alignment::columns() const {
  const bool motion = m_layout.motion >= 0;
  return {m_layout.num_shape,
          motion,
          motion ? static_cast<float>(0.5 / m_result.placement.motion_px.squaredNorm()) : 0.0F};
}

/// Normal matrix and gradient at the present parameters.
void Alignment::accumulate(bool light_only) {
  const int n = m_layout.size;
  std::array<double, (kMostColumns + 1) * (kMostColumns + 1)> gram{};
  AlignmentColumns wanted = columns();
  wanted.light_only = light_only;
  m_kernels.accumulate(m_window, m_workspace.samples(), light(), wanted, gram.data());
  m_normal.resize(n, n);
  m_gradient.resize(n);
  for (int r = 0; r <= n; ++r) {
    for (int c = 0; c <= r && c < n; ++c) {
      const double sum = gram[static_cast<std::size_t>(r * (n + 1) + c)];
      if (r == n) {
        m_gradient[c] = sum;
      } else {
        m_normal(r, c) = m_normal(c, r) = sum;
      }
    }
  }
}

/// Brightness alone: without any, the picture says nothing of the position.
void Alignment::find_light() {
  m_light.setZero();
  accumulate(true);
  const Eigen::Matrix4d block = m_normal.bottomRightCorner<4, 4>();
  m_light = block.ldlt().solve(Eigen::Vector4d(m_gradient.tail<4>()));
}

void Alignment::apply(const Parameters& delta) {
  MarkerPlacement& placement = m_result.placement;
  placement.position_px += delta.head<2>();
  const auto at = [&](int i) { return delta[m_layout.shape + i]; };
  if (m_layout.num_shape == 1) {
    m_turn += at(0);
    placement.px_from_pattern = turned(at(0)) * placement.px_from_pattern;
  } else if (m_layout.num_shape >= 3) {
    Eigen::Matrix2d stretch;
    stretch << at(0), at(2), at(m_layout.num_shape == 4 ? 3 : 2), at(1);
    placement.px_from_pattern += stretch * placement.px_from_pattern;
  }
  if (m_layout.motion >= 0) {
    const double length = placement.motion_px.norm();
    const double square = length * length + delta[m_layout.motion];
    // The path keeps a length, so that it keeps a direction and a derivative.
    const double wished = std::sqrt(std::max(square, 0.25));
    placement.motion_px *= std::clamp(wished / length, 0.5, 2.0);
  }
  m_light += delta.segment<4>(m_layout.light);
  m_result.light = m_light;
  m_result.contrast = m_light[1];
  m_result.turn_rad = m_turn;
}

/// One Gauss-Newton step, shortened where it would leave the neighbourhood in which it holds.
bool Alignment::solve(Parameters& delta, double& moved_px, bool& whole) const {
  const Eigen::LDLT<NormalMatrix> solver(m_normal);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return false;
  delta = solver.solve(m_gradient);
  if (!delta.allFinite()) return false;
  const double moved = delta.head<2>().norm();
  double shrink = std::min(1.0, kLargestStep * m_marker.size_px() / std::max(moved, 1e-12));
  moved_px = moved;
  if (m_layout.num_shape > 0) {
    const double stretch = delta.segment(m_layout.shape, m_layout.num_shape).norm();
    shrink = std::min(shrink, kLargestStretch / std::max(stretch, 1e-12));
    moved_px = std::max(moved, 0.5 * stretch * m_marker.size_px());
  }
  whole = shrink == 1.0;
  // Brightness is linear: it takes its whole step.
  delta.head(m_layout.light) *= shrink;
  return true;
}

/// Score, residual and sigma after the last step, by the linear model of it.
void Alignment::judge(const Parameters& step) {
  m_kernels.residuals(m_window,
                      m_workspace.samples(),
                      light(),
                      columns(),
                      step.data(),
                      m_workspace.residual(),
                      m_workspace.square_slope());
  const ResidualSums sums =
      m_kernels.sum_up(m_window,
                       m_workspace.samples(),
                       {kCounts,
                        static_cast<float>(kFlat * kFlat * m_light[1] * m_light[1]),
                        static_cast<float>(m_light[0] + 0.5 * m_light[1])},
                       m_workspace.residual(),
                       m_workspace.square_slope());
  const double variance = sums.flat > kFewestFlat
                              ? flat_variance(sums)
                              : sums.square / std::max(1.0, sums.count - m_layout.size);
  const NormalMatrix inverse =
      m_normal.ldlt().solve(NormalMatrix::Identity(m_layout.size, m_layout.size));
  m_result.sigma_px =
      std::sqrt(0.5 * (inverse(0, 0) + inverse(1, 1)) * variance + kSigmaFloor_px * kSigmaFloor_px);
  m_result.residual = std::sqrt(sums.square / std::max(1.0, sums.count));
  const double spread_grey = sums.grey_grey - sums.grey * sums.grey / sums.count;
  const double spread_model = sums.model_model - sums.model * sums.model / sums.count;
  const double product = (sums.grey_model - sums.grey * sums.model / sums.count) /
                         std::sqrt(spread_grey * spread_model);
  m_result.score = std::isfinite(product) ? (m_light[1] > 0.0 ? product : -product) : 0.0;
}

MarkerAlignment Alignment::run() {
  const MarkerPlacement start = m_result.placement;
  m_rough = m_layout.motion >= 0;
  if (!sample_model()) return m_result;
  if (m_options.light) {
    m_light = *m_options.light;
  } else {
    find_light();
  }
  const double enough_px = m_layout.num_shape > 1 ? kConverged_px : kAlmostThere_px;
  for (int i = 0; i < kMostIterations; ++i) {
    accumulate();
    if (!covered()) return m_result;
    Parameters delta;
    double moved_px = kInfinity;
    bool whole = false;
    if (!solve(delta, moved_px, whole)) return m_result;
    const bool lit = std::abs(delta[m_layout.light + 1]) < kSteadyLight * std::abs(m_light[1]);
    if (whole && lit && moved_px <= enough_px && !m_rough) {
      judge(delta);
      apply(delta);
      m_result.converged =
          std::isfinite(m_result.sigma_px) && std::abs(m_result.contrast) >= kLeastContrast;
      return m_result;
    }
    if (i >= kSettled && moved_px > kNear_px && m_layout.num_shape <= 1) return m_result;
    apply(delta);
    m_rough = m_rough && moved_px > kNear_px;
    const MarkerPlacement& now = m_result.placement;
    if ((now.position_px - start.position_px).norm() > m_options.farthest_px) return m_result;
    const double growth = now.px_from_pattern.determinant() / start.px_from_pattern.determinant();
    if (!(growth > 0.25 && growth < 4.0)) return m_result;
    if (now.motion_px.norm() >
        std::max(kLongestPath * m_marker.size_px(), kMostPathGrowth * start.motion_px.norm())) {
      return m_result;
    }
    if (!sample_model()) return m_result;
  }
  return m_result;
}

}  // namespace

MarkerPlacement upright_marker(const Eigen::Vector2d& position_px,
                               double size_px,
                               double turn_rad) {
  return {position_px, size_px * turned(turn_rad), Eigen::Vector2d::Zero()};
}

MarkerAlignment align_marker(const LumaFrame& frame,
                             const MarkerTemplate& marker,
                             const MarkerPlacement& start,
                             const AlignOptions& options) {
  return Alignment(frame, marker, start, options).run();
}

LumaFrame luma_view(const Image& grey) {
  return {grey.pixels.data(), grey.width_px, grey.width_px, grey.height_px, 0.0};
}

}  // namespace twang
