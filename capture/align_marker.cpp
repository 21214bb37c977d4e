// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/align_marker.hpp"

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

constexpr int kMostParameters = 11;  // position 2, shape 4, motion 1, brightness 4
constexpr int kMostIterations = 25;
constexpr double kConverged_px = 1e-3;   // last step; the error left is its square
constexpr double kLargestStep = 0.2;     // of the position, in marker sizes
constexpr double kLargestStretch = 0.1;  // of the shape, per iteration
// The rim of paper that is used, beyond the marker: as far as pixel and usual blurs reach, and
// within the quarter of the size that a paper square of 1.5 sizes leaves. The same for all blurs,
// so that their residuals can be compared.
constexpr double kLeastRim = 0.075;
constexpr double kWidestRim = 0.22;
constexpr double kRim_px = 2.0;
constexpr double kTaper_px = 1.0;
// Neighbouring residuals' correlation that counts as noise; what goes beyond is misfit, symmetric
// about the marker and so without effect on its place.
constexpr double kMostCorrelation = 0.5;
// Between paper and ink; with less there is nothing to be seen [grey levels].
constexpr double kLeastContrast = 1.0;
// Of the pixels that the marker should cover, this part must lie in the picture.
constexpr double kLeastCover = 0.9;

using Parameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostParameters, 1>;
using NormalMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostParameters, kMostParameters>;
using Row = std::array<double, kMostParameters>;

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

/// The rectangle of pixels that a marker's window can touch, cut to the picture.
struct Window {
  int x0, x1, y0, y1;  // half open
};

class Alignment {
 public:
  Alignment(const LumaFrame& frame,
            const MarkerTemplate& marker,
            const MarkerPlacement& start,
            const AlignOptions& options)
      : m_frame(frame), m_marker(marker), m_options(options), m_layout(marker, options) {
    m_result.placement = start;
    m_window = start.px_from_pattern;
    m_window_from_px = m_window.inverse();
    m_rim = marker.has_rim() ? std::clamp(kRim_px / marker.size_px(), kLeastRim, kWidestRim) : 0.0;
    m_taper = kTaper_px / marker.size_px();
  }

  MarkerAlignment run();

 private:
  MarkerTemplate::Sample smeared(double u, double v, double& by_motion) const;
  double weight(const Eigen::Vector2d& offset) const;
  Window window() const;
  void fill_row(const Eigen::Vector2d& offset, double u, double v, Row& row, double& value) const;
  bool accumulate();
  bool step(double& moved_px);
  void apply(const Parameters& delta);
  void judge();

  const LumaFrame& m_frame;
  const MarkerTemplate& m_marker;
  const AlignOptions& m_options;
  Layout m_layout;
  MarkerAlignment m_result;
  double m_rim = 0.0;
  double m_taper = 0.0;
  Eigen::Matrix2d m_window;  // px from the window's units, as the marker was at the start
  Eigen::Matrix2d m_window_from_px;
  Eigen::Matrix2d m_pattern_from_px;
  Eigen::Vector2d m_path;  // motion in the pattern's units
  int m_path_samples = 1;
  Eigen::Vector4d m_light = Eigen::Vector4d::Zero();  // ink, contrast, slopes
  NormalMatrix m_normal;
  Parameters m_gradient;
  double m_turn = 0.0;
  double m_cover = 0.0;
  double m_total_weight = 0.0;
};

/// Template averaged along the path of motion, and its derivative by the squared length of that
/// path [1/px²].
MarkerTemplate::Sample Alignment::smeared(double u, double v, double& by_motion) const {
  by_motion = 0.0;
  if (m_path_samples == 1 && m_layout.motion < 0) return m_marker.at(u, v);
  MarkerTemplate::Sample sum{0.0, 0.0, 0.0};
  for (int k = 0; k < m_path_samples; ++k) {
    const double s = (k + 0.5) / m_path_samples - 0.5;
    const auto sample = m_marker.at(u + s * m_path.x(), v + s * m_path.y());
    sum.value += sample.value / m_path_samples;
    sum.du += sample.du / m_path_samples;
    sum.dv += sample.dv / m_path_samples;
  }
  if (m_layout.motion >= 0) {
    // d/dL of the mean over a path of length L is (mean of its ends − mean) / L.
    const double ends = 0.5 * (m_marker.at(u + 0.5 * m_path.x(), v + 0.5 * m_path.y()).value +
                               m_marker.at(u - 0.5 * m_path.x(), v - 0.5 * m_path.y()).value);
    by_motion = (ends - sum.value) / (2.0 * m_result.placement.motion_px.squaredNorm());
  }
  return sum;
}

/// 1 over the marker and its rim, falling to 0 over the last pixel of it. The window keeps the
/// shape the marker had at the start: residuals of different shapes are then comparable.
double Alignment::weight(const Eigen::Vector2d& offset) const {
  const Eigen::Vector2d uv = m_window_from_px * offset;
  const double distance = m_marker.is_round() ? uv.norm() : uv.cwiseAbs().maxCoeff();
  return std::clamp((0.5 + m_rim - distance) / m_taper, 0.0, 1.0);
}

Window Alignment::window() const {
  const Eigen::Vector2d reach = (0.5 + m_rim) * m_window.cwiseAbs().rowwise().sum();
  const Eigen::Vector2d& at = m_result.placement.position_px;
  return {std::max(0, static_cast<int>(std::ceil(at.x() - reach.x()))),
          std::min(m_frame.width_px, static_cast<int>(std::floor(at.x() + reach.x())) + 1),
          std::max(0, static_cast<int>(std::ceil(at.y() - reach.y()))),
          std::min(m_frame.height_px, static_cast<int>(std::floor(at.y() + reach.y())) + 1)};
}

/// The model's value at one pixel and its derivatives by all parameters.
void Alignment::fill_row(
    const Eigen::Vector2d& offset, double u, double v, Row& row, double& value) const {
  double by_motion = 0.0;
  const MarkerTemplate::Sample t = smeared(u, v, by_motion);
  const double gain = m_light[1] + m_light[2] * u + m_light[3] * v;
  value = m_light[0] + gain * t.value;
  const Eigen::RowVector2d by_pattern(gain * t.du + m_light[2] * t.value,
                                      gain * t.dv + m_light[3] * t.value);
  const Eigen::RowVector2d by_px = by_pattern * m_pattern_from_px;
  row[0] = -by_px.x();
  row[1] = -by_px.y();
  const auto at = [&](int i) -> double& { return row[static_cast<std::size_t>(i)]; };
  if (m_layout.num_shape == 1) {
    at(m_layout.shape) = -(by_px.x() * offset.y() - by_px.y() * offset.x());
  } else if (m_layout.num_shape >= 3) {
    at(m_layout.shape) = -by_px.x() * offset.x();
    at(m_layout.shape + 1) = -by_px.y() * offset.y();
    at(m_layout.shape + 2) = -by_px.x() * offset.y();
    if (m_layout.num_shape == 4) {
      at(m_layout.shape + 3) = -by_px.y() * offset.x();
    } else {
      at(m_layout.shape + 2) -= by_px.y() * offset.x();
    }
  }
  if (m_layout.motion >= 0) at(m_layout.motion) = gain * by_motion;
  at(m_layout.light) = 1.0;
  at(m_layout.light + 1) = t.value;
  at(m_layout.light + 2) = u * t.value;
  at(m_layout.light + 3) = v * t.value;
}

/// Normal matrix and gradient at the present parameters; false if too little of the marker is in
/// the picture.
bool Alignment::accumulate() {
  const MarkerPlacement& placement = m_result.placement;
  m_pattern_from_px = placement.px_from_pattern.inverse();
  m_path = m_pattern_from_px * placement.motion_px;
  m_path_samples = 1 + static_cast<int>(std::ceil(placement.motion_px.norm()));
  const int n = m_layout.size;
  m_normal.setZero(n, n);
  m_gradient.setZero(n);
  m_total_weight = 0.0;
  const Window area = window();
  Row row{};
  for (int y = area.y0; y < area.y1; ++y) {
    const std::uint8_t* pixels = m_frame.pixels + y * m_frame.stride;
    for (int x = area.x0; x < area.x1; ++x) {
      const Eigen::Vector2d offset = Eigen::Vector2d(x, y) - placement.position_px;
      const double w = weight(offset);
      if (w <= 0.0) continue;
      const Eigen::Vector2d uv = m_pattern_from_px * offset;
      double value = 0.0;
      fill_row(offset, uv.x(), uv.y(), row, value);
      const double difference = w * (pixels[x] - value);
      for (int i = 0; i < n; ++i) {
        const double wi = w * row[static_cast<std::size_t>(i)];
        m_gradient[i] += difference * row[static_cast<std::size_t>(i)];
        for (int j = 0; j <= i; ++j) m_normal(i, j) += wi * row[static_cast<std::size_t>(j)];
      }
      m_total_weight += w;
    }
  }
  const double side = 1.0 + 2.0 * m_rim - m_taper;
  const double expected =
      (m_marker.is_round() ? kPi / 4.0 : 1.0) * side * side * std::abs(m_window.determinant());
  m_cover = m_total_weight / expected;
  return m_cover >= kLeastCover && m_total_weight > 2.0 * n;
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
}

/// One Gauss-Newton step.
bool Alignment::step(double& moved_px) {
  if (!accumulate()) return false;
  const NormalMatrix full = m_normal.selfadjointView<Eigen::Lower>();
  const Eigen::LDLT<NormalMatrix> solver(full);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return false;
  Parameters delta = solver.solve(m_gradient);
  if (!delta.allFinite()) return false;
  const double moved = delta.head<2>().norm();
  double shrink = std::min(1.0, kLargestStep * m_marker.size_px() / std::max(moved, 1e-12));
  if (m_layout.num_shape > 0) {
    const double stretch = delta.segment(m_layout.shape, m_layout.num_shape).norm();
    shrink = std::min(shrink, kLargestStretch / std::max(stretch, 1e-12));
    moved_px = std::max(moved, 0.5 * stretch * m_marker.size_px());
  } else {
    moved_px = moved;
  }
  // Brightness is linear: it takes its whole step.
  delta.head(m_layout.light) *= shrink;
  apply(delta);
  return true;
}

/// Score, residual and sigma at the last parameters.
void Alignment::judge() {
  const Window area = window();
  const MarkerPlacement& placement = m_result.placement;
  const std::size_t width = static_cast<std::size_t>(std::max(0, area.x1 - area.x0));
  std::vector<double> above(width, kNaN);
  double sum_w = 0.0, sum_i = 0.0, sum_m = 0.0, sum_ii = 0.0, sum_mm = 0.0, sum_im = 0.0;
  double square = 0.0, beside = 0.0, below = 0.0;
  double num_beside = 0.0, num_below = 0.0;
  Row row{};
  for (int y = area.y0; y < area.y1; ++y) {
    double left = kNaN;
    for (int x = area.x0; x < area.x1; ++x) {
      const Eigen::Vector2d offset = Eigen::Vector2d(x, y) - placement.position_px;
      const Eigen::Vector2d uv = m_pattern_from_px * offset;
      const double w = weight(offset);
      double& over = above[static_cast<std::size_t>(x - area.x0)];
      if (w < 0.5) {
        left = over = kNaN;
        continue;
      }
      double model = 0.0;
      fill_row(offset, uv.x(), uv.y(), row, model);
      const double pixel = m_frame.pixels[y * m_frame.stride + x];
      const double r = pixel - model;
      sum_w += 1.0;
      sum_i += pixel;
      sum_m += model;
      sum_ii += pixel * pixel;
      sum_mm += model * model;
      sum_im += pixel * model;
      square += r * r;
      if (!std::isnan(left)) beside += r * left, num_beside += 1.0;
      if (!std::isnan(over)) below += r * over, num_below += 1.0;
      left = over = r;
    }
  }
  const double variance = square / std::max(1.0, sum_w - m_layout.size);
  const auto widening = [&](double sum, double count) {
    const double rho = count > 0.0 && square > 0.0 ? sum / count / (square / sum_w) : 0.0;
    const double bounded = std::clamp(rho, 0.0, kMostCorrelation);
    return (1.0 + bounded) / (1.0 - bounded);
  };
  const double correlated = widening(beside, num_beside) * widening(below, num_below);
  const NormalMatrix full = m_normal.selfadjointView<Eigen::Lower>();
  const NormalMatrix inverse =
      full.ldlt().solve(NormalMatrix::Identity(m_layout.size, m_layout.size));
  m_result.sigma_px = std::sqrt(0.5 * (inverse(0, 0) + inverse(1, 1)) * variance * correlated +
                                kSigmaFloor_px * kSigmaFloor_px);
  m_result.residual = std::sqrt(square / std::max(1.0, sum_w));
  const double spread_i = sum_ii - sum_i * sum_i / sum_w;
  const double spread_m = sum_mm - sum_m * sum_m / sum_w;
  const double product = (sum_im - sum_i * sum_m / sum_w) / std::sqrt(spread_i * spread_m);
  m_result.contrast = m_light[1];
  m_result.ink = m_light[0];
  m_result.turn_rad = m_turn;
  m_result.score = std::isfinite(product) ? (m_light[1] > 0.0 ? product : -product) : 0.0;
}

MarkerAlignment Alignment::run() {
  const MarkerPlacement start = m_result.placement;
  double moved_px = kInfinity;
  // The first pass finds the brightness alone: with none, the picture says nothing of the position.
  {
    const Layout full = m_layout;
    if (!accumulate()) return m_result;
    const Eigen::Matrix4d block =
        NormalMatrix(m_normal.selfadjointView<Eigen::Lower>()).block<4, 4>(full.light, full.light);
    m_light += block.ldlt().solve(Eigen::Vector4d(m_gradient.segment<4>(full.light)));
  }
  for (int i = 0; i < kMostIterations && moved_px > kConverged_px; ++i) {
    if (!step(moved_px)) return m_result;
    const MarkerPlacement& now = m_result.placement;
    if ((now.position_px - start.position_px).norm() > m_options.farthest_px) return m_result;
    const double growth = now.px_from_pattern.determinant() / start.px_from_pattern.determinant();
    if (!(growth > 0.25 && growth < 4.0)) return m_result;
  }
  if (!accumulate()) return m_result;
  judge();
  m_result.converged = moved_px <= 10.0 * kConverged_px && std::isfinite(m_result.sigma_px) &&
                       std::abs(m_result.contrast) >= kLeastContrast;
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
