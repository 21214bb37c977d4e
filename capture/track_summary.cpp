// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_summary.hpp"

#include "core/constants.hpp"
#include "core/units.hpp"

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

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
    summary.noise_floor_px = track.noise_floor_px;
    const Channel* sigma = result.trace.find(track.id + ".sigma_mm");
    summary.sigma_mm = sigma ? median(sigma->values) : kNaN;
    if (const Marker* marker = rig.find_marker(track.id)) {
      summary.fixed = marker->fixed;
      summary.travel_mm = travel(displacement_mm(rig, result.trace, *marker));
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
