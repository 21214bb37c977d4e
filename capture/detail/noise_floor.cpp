// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/noise_floor.hpp"

#include "core/constants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace twang::detail {
namespace {

// A tenth of the still stretches is at least as quiet as the quietest of noise alone; stretches of
// noise alone vary by less than this factor of variance about that (chi-square of 20).
constexpr double kQuietest = 0.1;
constexpr double kAboutAsQuiet = 3.0;
constexpr int kFewestSamples = 9;  // of a stretch, the rest lost

struct Stretch {
  double variance = 0.0;         // of a coordinate about a straight line
  double stated_variance = 0.0;  // mean
};

std::optional<Stretch> stretch_at(const std::vector<Eigen::Vector2d>& positions,
                                  const std::vector<double>& sigmas,
                                  std::size_t begin) {
  double count = 0.0;
  double t_sum = 0.0;
  double tt_sum = 0.0;
  double stated = 0.0;
  Eigen::Vector2d p_sum = Eigen::Vector2d::Zero();
  Eigen::Vector2d tp_sum = Eigen::Vector2d::Zero();
  Eigen::Vector2d pp_sum = Eigen::Vector2d::Zero();
  std::optional<Eigen::Vector2d> origin;
  for (std::size_t k = 0; k < static_cast<std::size_t>(kStillFrames); ++k) {
    const Eigen::Vector2d& at = positions[begin + k];
    if (!at.allFinite()) continue;
    if (!origin) origin = at;
    const Eigen::Vector2d p = at - *origin;
    const auto t = static_cast<double>(k);
    count += 1.0;
    t_sum += t;
    tt_sum += t * t;
    p_sum += p;
    tp_sum += t * p;
    pp_sum += p.cwiseAbs2();
    stated += sigmas[begin + k] * sigmas[begin + k];
  }
  if (count < kFewestSamples) return std::nullopt;
  const double tt = tt_sum - t_sum * t_sum / count;
  const Eigen::Vector2d tp = tp_sum - t_sum / count * p_sum;
  const Eigen::Vector2d pp = pp_sum - p_sum.cwiseAbs2() / count;
  const double squares = (pp - tp.cwiseAbs2() / tt).cwiseMax(0.0).sum();
  return Stretch{squares / (2.0 * (count - 2.0)), stated / count};
}

}  // namespace

double scatter_while_still(const std::vector<Eigen::Vector2d>& positions,
                           const std::vector<double>& sigmas) {
  constexpr std::size_t kStep = kStillFrames / 2;
  std::vector<double> still;
  for (std::size_t begin = 0; begin + kStillFrames <= positions.size(); begin += kStep) {
    const auto stretch = stretch_at(positions, sigmas, begin);
    if (!stretch) continue;
    if (stretch->variance <= kStillOverSigma * kStillOverSigma * stretch->stated_variance) {
      still.push_back(stretch->variance);
    }
  }
  if (still.empty()) return kNaN;
  std::sort(still.begin(), still.end());
  const auto tenth = static_cast<std::size_t>(kQuietest * static_cast<double>(still.size()));
  const double most = kAboutAsQuiet * still[tenth];
  double sum = 0.0;
  double count = 0.0;
  for (const double variance : still) {
    if (variance > most) break;
    sum += variance;
    count += 1.0;
  }
  return std::sqrt(sum / count);
}

std::string describe_noise_floors(const std::vector<MarkerTrack>& tracks,
                                  const std::vector<bool>& fixed,
                                  double mm_per_px) {
  double low = kInfinity;
  double high = 0.0;
  std::string ids;
  int count = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (fixed[i] || !std::isfinite(tracks[i].noise_floor_px)) continue;
    low = std::min(low, tracks[i].noise_floor_px);
    high = std::max(high, tracks[i].noise_floor_px);
    ids = tracks[i].id;
    ++count;
  }
  if (count == 0) return {};
  if (count == 1) {
    return fmt::format(
        "While still, marker '{}' scatters by {:.2g} px ({:.2g} mm).", ids, high, high * mm_per_px);
  }
  return fmt::format(
      "While still, {} moving markers scatter by {:.2g} to {:.2g} px ({:.2g} to {:.2g} mm).",
      count,
      low,
      high,
      low * mm_per_px,
      high * mm_per_px);
}

}  // namespace twang::detail
