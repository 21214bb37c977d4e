// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/motion_fit.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang::detail {
namespace {

using Points = std::vector<Eigen::Vector2d>;

// Farther than so many sigmas from where the others put it a marker has moved by itself.
constexpr double kBumpSigmas = 6.0;
constexpr std::size_t kFirstFrames = 15;  // that say where a marker first stood
constexpr int kRounds = 3;                // of maps from means and means from maps
// Weak belief that the camera neither zooms nor turns, which decides between pairs of three.
constexpr double kUsualZoom = 0.02;  // one sigma [-]
constexpr double kUsualTurn = 0.1;   // [rad]

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Eigen::Vector2d median_of(const Points& points) {
  std::vector<double> x;
  std::vector<double> y;
  for (const auto& point : points) {
    x.push_back(point.x());
    y.push_back(point.y());
  }
  return {median_of(std::move(x)), median_of(std::move(y))};
}

Eigen::Vector2d mean_of(const Points& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

}  // namespace

MotionFit::MotionFit(const std::vector<FixedMarker>& markers, std::optional<MapKind> kind)
    : m_markers(markers), m_kind(kind), m_num_frames(markers.front().position_px->size()) {
  m_mean.assign(markers.size(), Eigen::Vector2d::Constant(kNaN));
  m_left_out.assign(markers.size(), std::vector<bool>(m_num_frames, false));
  m_fits.resize(m_num_frames);
  begin();
  for (int round = 0; round < kRounds; ++round) {
    fit_frames();
    average(round == 0);
  }
  fit_frames();
  judge();
}

CameraMotion MotionFit::result() && {
  CameraMotion motion;
  motion.kind = m_kind;
  motion.mean_px = std::move(m_mean);
  if (m_kind) motion.mean_from_frame = std::move(m_fits);
  motion.left_out = std::move(m_left_out);
  motion.left_px = rms_px;
  motion.widening = std::sqrt(std::max(1.0, reduced()));
  return motion;
}

double MotionFit::own_chi_square(std::size_t i) const {
  Points seen;
  for (const auto& px : *m_markers[i].position_px) {
    if (px.allFinite()) seen.push_back(px);
  }
  const Eigen::Vector2d middle = median_of(seen);
  double sum = 0.0;
  for (std::size_t n = 0; n < m_num_frames; ++n) {
    const Eigen::Vector2d& px = (*m_markers[i].position_px)[n];
    if (px.allFinite()) sum += (px - middle).squaredNorm() / std::pow(sigma(i, n), 2);
  }
  return sum / (2.0 * static_cast<double>(seen.size()));
}

double MotionFit::bump_px(std::size_t i, std::size_t n) const {
  return std::max(kBump_px, kBumpSigmas * sigma(i, n));
}

MotionFit::Seen MotionFit::seen(std::size_t n) const {
  Seen result;
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    const Eigen::Vector2d& px = (*m_markers[i].position_px)[n];
    if (!px.allFinite() || !m_mean[i].allFinite()) continue;
    result.which.push_back(i);
    result.pairs.from.push_back(px);
    result.pairs.to.push_back(m_mean[i]);
    result.pairs.sigma.push_back(sigma(i, n));
  }
  return result;
}

void MotionFit::begin() {
  std::size_t best = 0;
  std::size_t most = 0;
  for (std::size_t n = 0; n < m_num_frames; ++n) {
    const auto count = static_cast<std::size_t>(
        std::count_if(m_markers.begin(), m_markers.end(), [&](const FixedMarker& marker) {
          return (*marker.position_px)[n].allFinite();
        }));
    if (count > most) {
      most = count;
      best = n;
    }
  }
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    m_mean[i] = (*m_markers[i].position_px)[best];
  }
  for (std::size_t n = 0; n < m_num_frames; ++n) {
    std::optional<Homography> map;
    for (std::size_t i = 0; i < m_markers.size(); ++i) {
      const Eigen::Vector2d& px = (*m_markers[i].position_px)[n];
      if (m_mean[i].allFinite() || !px.allFinite()) continue;
      if (!map) map = fit_frame(n).map;
      m_mean[i] = map_point(*map, px);
    }
  }
}

MapKind MotionFit::kind_for(std::size_t count) const {
  if (*m_kind == MapKind::Projective && count >= 4) return MapKind::Projective;
  return *m_kind != MapKind::Shift && count >= 2 ? MapKind::Similarity : MapKind::Shift;
}

MapFit MotionFit::fit_allowed(const PointPairs& pairs) const {
  const MapKind kind = kind_for(pairs.from.size());
  if (kind != MapKind::Projective) return fit_map(kind, pairs);
  try {
    return fit_map(kind, pairs);
  } catch (const InputError&) {
    return fit_map(MapKind::Similarity, pairs);  // those seen in this frame are on a line
  }
}

double MotionFit::cost_of(const Homography& map, const Seen& seen, std::size_t n) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < seen.which.size(); ++k) {
    const double off = (map_point(map, seen.pairs.from[k]) - seen.pairs.to[k]).norm();
    sum += std::pow(std::min(off, bump_px(seen.which[k], n)) / seen.pairs.sigma[k], 2);
  }
  const double zoom = 0.5 * std::log(std::abs(map.topLeftCorner<2, 2>().determinant()));
  const double turn = std::atan2(map(1, 0) - map(0, 1), map(0, 0) + map(1, 1));
  return sum + std::pow(zoom / kUsualZoom, 2) + std::pow(turn / kUsualTurn, 2);
}

MotionFit::Seen MotionFit::explained(const Homography& map, const Seen& all, std::size_t n) const {
  Seen kept;
  for (std::size_t k = 0; k < all.which.size(); ++k) {
    const double off = (map_point(map, all.pairs.from[k]) - all.pairs.to[k]).norm();
    if (off > bump_px(all.which[k], n)) continue;
    kept.which.push_back(all.which[k]);
    kept.pairs.from.push_back(all.pairs.from[k]);
    kept.pairs.to.push_back(all.pairs.to[k]);
    kept.pairs.sigma.push_back(all.pairs.sigma[k]);
  }
  return kept;
}

MapFit MotionFit::fit_frame(std::size_t n) const {
  MapFit none;
  if (!m_kind) return none;
  const Seen all = seen(n);
  if (all.which.empty()) {
    none.map.setConstant(kNaN);
    return none;
  }
  MapFit best = fit_allowed(all.pairs);
  if (explained(best.map, all, n).which.size() == all.which.size()) return best;
  double least = cost_of(best.map, all, n);
  for (std::size_t i = 0; i < all.which.size(); ++i) {
    for (std::size_t j = i + 1; j < all.which.size(); ++j) {
      const PointPairs two{{all.pairs.from[i], all.pairs.from[j]},
                           {all.pairs.to[i], all.pairs.to[j]},
                           {all.pairs.sigma[i], all.pairs.sigma[j]}};
      MapFit fit = fit_allowed(two);
      const Seen kept = explained(fit.map, all, n);
      if (kept.which.size() >= 2) fit = fit_allowed(kept.pairs);
      const double price = cost_of(fit.map, all, n);
      if (price < least) {
        least = price;
        best = fit;
      }
    }
  }
  return best;
}

void MotionFit::borrow_turns() {
  if (!m_kind || *m_kind == MapKind::Shift) return;
  const MapFit* last = nullptr;
  const auto visit = [&](std::size_t n) {
    const Seen all = seen(n);
    if (all.which.size() >= 2) last = &m_fits[n];
    if (all.which.size() != 1 || last == nullptr) return;
    MapFit borrowed = *last;
    const Eigen::Vector2d off = all.pairs.to[0] - map_point(last->map, all.pairs.from[0]);
    Homography shift = Homography::Identity();
    shift.topRightCorner<2, 1>() = off;
    borrowed.map = shift * last->map;
    m_fits[n] = borrowed;
  };
  for (std::size_t n = m_num_frames; n-- > 0;) visit(n);
  last = nullptr;
  for (std::size_t n = 0; n < m_num_frames; ++n) visit(n);
}

void MotionFit::fit_frames() {
  for (std::size_t n = 0; n < m_num_frames; ++n) m_fits[n] = fit_frame(n);
  borrow_turns();
  for (auto& marker : m_left_out) marker.assign(m_num_frames, false);
  for (std::size_t n = 0; n < m_num_frames; ++n) {
    if (!m_fits[n].map.allFinite()) continue;
    const Seen all = seen(n);
    for (std::size_t k = 0; k < all.which.size(); ++k) {
      const double off = (map_point(m_fits[n].map, all.pairs.from[k]) - all.pairs.to[k]).norm();
      m_left_out[all.which[k]][n] = off > bump_px(all.which[k], n);
    }
  }
}

void MotionFit::average(bool first) {
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    Points steady;
    for (std::size_t n = 0; n < m_num_frames; ++n) {
      const Eigen::Vector2d& px = (*m_markers[i].position_px)[n];
      if (!px.allFinite() || (!first && m_left_out[i][n])) continue;
      steady.push_back(map_point(m_fits[n].map, px));
      if (first && steady.size() == kFirstFrames) break;
    }
    if (steady.empty()) continue;
    m_mean[i] = first ? median_of(steady) : mean_of(steady);
  }
}

void MotionFit::judge() {
  freedom = -2.0 * static_cast<double>(m_markers.size());
  double square = 0.0;
  double count = 0.0;
  for (std::size_t n = 0; n < m_num_frames; ++n) {
    const Seen all = seen(n);
    double kept = 0.0;
    for (std::size_t k = 0; k < all.which.size(); ++k) {
      const double off2 =
          (map_point(m_fits[n].map, all.pairs.from[k]) - all.pairs.to[k]).squaredNorm();
      const double in_sigmas = off2 / std::pow(all.pairs.sigma[k], 2);
      if (m_left_out[all.which[k]][n]) {
        cost += std::pow(bump_px(all.which[k], n) / all.pairs.sigma[k], 2);
        share_left_out += 1.0;
        continue;
      }
      cost += in_sigmas;
      m_inlier_cost += in_sigmas;
      square += off2;
      kept += 2.0;
    }
    count += kept;
    if (!m_kind || all.which.empty()) {
      freedom += kept;
      continue;
    }
    const double spent =
        num_parameters(kind_for(std::max<std::size_t>(1, static_cast<std::size_t>(kept / 2.0))));
    parameters += spent;
    freedom += std::max(0.0, kept - spent);
  }
  rms_px = count > 0.0 ? std::sqrt(square / count) : 0.0;
  share_left_out /= share_left_out + std::max(1.0, 0.5 * count);
}

double scatter_of(const std::vector<FixedMarker>& markers) {
  double square = 0.0;
  double count = 0.0;
  for (const FixedMarker& marker : markers) {
    Points seen;
    for (const auto& px : *marker.position_px) {
      if (px.allFinite()) seen.push_back(px);
    }
    const Eigen::Vector2d mean = mean_of(seen);
    for (const auto& px : seen) square += (px - mean).squaredNorm();
    count += 2.0 * static_cast<double>(seen.size());
  }
  return std::sqrt(square / count);
}

}  // namespace twang::detail
