// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_summary.hpp"

#include "core/constants.hpp"
#include "core/units.hpp"

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

constexpr std::size_t kBlock = 20;     // frames: short beside a vibration's decay
constexpr int kFewestForResidual = 3;  // fixed markers; two are met exactly by a similarity

double median(std::vector<double> values) {
  values.erase(
      std::remove_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); }),
      values.end());
  if (values.empty()) return kNaN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Variance of one coordinate of a block about a straight line through it.
double variance_about_line(const std::vector<Eigen::Vector2d>& block) {
  const auto count = static_cast<double>(block.size());
  const double middle = 0.5 * (count - 1.0);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  double spread = 0.0;
  for (std::size_t i = 0; i < block.size(); ++i) {
    const double t = static_cast<double>(i) - middle;
    mean += block[i] / count;
    slope += t * block[i];
    spread += t * t;
  }
  slope /= spread;
  double squares = 0.0;
  for (std::size_t i = 0; i < block.size(); ++i) {
    squares += (block[i] - mean - slope * (static_cast<double>(i) - middle)).squaredNorm();
  }
  return squares / (2.0 * (count - 2.0));
}

std::vector<TimedLoss> timed_losses(const MarkerTrack& track, const std::vector<double>& time_s) {
  std::vector<TimedLoss> losses;
  for (const LostStretch& stretch : track.lost) {
    const std::size_t last = stretch.first_frame + stretch.num_frames - 1;
    losses.push_back({stretch,
                      stretch.first_frame < time_s.size() ? time_s[stretch.first_frame] : kNaN,
                      last < time_s.size() ? time_s[last] : kNaN});
  }
  return losses;
}

double travel(const std::vector<Eigen::Vector2d>& path) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(kInfinity);
  Eigen::Vector2d high = -low;
  for (const Eigen::Vector2d& at : path) {
    if (!at.allFinite()) continue;
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  return low.allFinite() ? (high - low).norm() : kNaN;
}

}  // namespace

double noise_floor(const std::vector<Eigen::Vector2d>& position_px, const std::vector<bool>& skip) {
  std::vector<double> variances;
  std::vector<Eigen::Vector2d> block;
  for (std::size_t n = 0; n < position_px.size(); ++n) {
    if (n < skip.size() && skip[n]) continue;
    if (!position_px[n].allFinite()) {
      block.clear();
      continue;
    }
    block.push_back(position_px[n]);
    if (block.size() < kBlock) continue;
    variances.push_back(variance_about_line(block));
    block.clear();
  }
  if (variances.empty()) return kNaN;
  const auto tenth = variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 10);
  std::nth_element(variances.begin(), tenth, variances.end());
  return std::sqrt(*tenth);
}

std::vector<Eigen::Vector2d> displacement_mm(const Rig& rig,
                                             const Trace& trace,
                                             const Marker& marker) {
  std::vector<Eigen::Vector2d> path(trace.num_samples(), Eigen::Vector2d::Zero());
  bool shown = false;
  for (const auto& [axis, letter] : {std::pair{0, 'x'}, {1, 'y'}, {2, 'z'}}) {
    const Channel* channel = trace.find(marker.id + '.' + letter + "_mm");
    if (channel == nullptr) continue;
    shown = true;
    const Eigen::Vector2d along(rig.camera->image_right[axis], rig.camera->image_down[axis]);
    for (std::size_t n = 0; n < path.size(); ++n) {
      path[n] += along * (channel->values[n] - kMillimetresPerMetre * marker.position[axis]);
    }
  }
  if (!shown) std::fill(path.begin(), path.end(), Eigen::Vector2d::Constant(kNaN));
  return path;
}

std::vector<MarkerSummary> summarize_markers(const Rig& rig, const TrackResult& result) {
  std::vector<MarkerSummary> summaries;
  for (const MarkerTrack& track : result.tracks) {
    MarkerSummary summary;
    summary.id = track.id;
    summary.lost = timed_losses(track, result.trace.time_s);
    summary.frames_lost = track.frames_lost;
    summary.frames_seen = static_cast<int>(track.position_px.size()) - track.frames_lost;
    summary.sigma_px = median(track.sigma_px);
    const Channel* sigma = result.trace.find(track.id + ".sigma_mm");
    summary.sigma_mm = sigma ? median(sigma->values) : kNaN;
    if (const Marker* marker = rig.find_marker(track.id)) {
      summary.fixed = marker->fixed;
      std::vector<Eigen::Vector2d> path = displacement_mm(rig, result.trace, *marker);
      summary.travel_mm = travel(path);
      for (Eigen::Vector2d& at : path) at /= result.mm_per_px;
      summary.noise_floor_px = noise_floor(path, result.doubled);
    }
    summaries.push_back(std::move(summary));
  }
  return summaries;
}

std::vector<double> plane_residual_by_frame(const Rig& rig, const TrackResult& result) {
  std::vector<double> squares(result.trace.num_samples(), 0.0);
  std::vector<int> seen(result.trace.num_samples(), 0);
  for (const Marker& marker : rig.markers) {
    if (!marker.fixed) continue;
    const std::vector<Eigen::Vector2d> path = displacement_mm(rig, result.trace, marker);
    for (std::size_t n = 0; n < path.size(); ++n) {
      if (!path[n].allFinite()) continue;
      squares[n] += path[n].squaredNorm();
      ++seen[n];
    }
  }
  std::vector<double> residual(squares.size(), kNaN);
  for (std::size_t n = 0; n < squares.size(); ++n) {
    if (seen[n] >= kFewestForResidual) {
      residual[n] = std::sqrt(squares[n] / seen[n]) / result.mm_per_px;
    }
  }
  return residual;
}

}  // namespace twang
