// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/strangers.hpp"

#include "capture/detail/in_parallel.hpp"

#include <algorithm>

namespace twang::detail {
namespace {

constexpr double kThingsApart = 0.5;  // of two things' centres, in sizes
constexpr double kLookAlike = 0.75;   // correlation of a thing that could be taken for a marker
constexpr double kLookAround = 6.0;   // for such things, in sizes

}  // namespace

std::vector<Stranger> find_strangers(const LumaFrame& frame,
                                     std::vector<MarkerFollower>& followers,
                                     const std::vector<MarkerSample>& first) {
  std::vector<std::vector<Eigen::Vector2d>> look_alikes(followers.size());
  for_each_in_parallel(followers.size(), [&](std::size_t i) {
    if (!followers[i].seen()) return;
    look_alikes[i] = followers[i].look_alikes(frame, kLookAround, kLookAlike);
  });
  std::vector<Stranger> strangers;
  for (std::size_t i = 0; i < followers.size(); ++i) {
    const double apart_px = kThingsApart * followers[i].size_px();
    for (const Eigen::Vector2d& px : look_alikes[i]) {
      bool a_marker = false;
      for (std::size_t k = 0; k < followers.size(); ++k) {
        a_marker |= followers[k].seen() ? (first[k].position_px - px).norm() < apart_px
                                        : followers[k].within_reach(px);
      }
      if (a_marker || !followers[i].look_at(frame, px).good()) continue;
      followers[i].keep_off((px - first[i].position_px).norm());
      const bool known = std::any_of(strangers.begin(), strangers.end(), [&](const Stranger& s) {
        return (s.px - px).norm() < apart_px;
      });
      if (!known) strangers.push_back({i, px});
    }
  }
  return strangers;
}

}  // namespace twang::detail
