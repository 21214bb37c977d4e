// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/follow_layout.hpp"

#include "capture/detail/assign_markers.hpp"
#include "capture/detail/start_followers.hpp"
#include "core/constants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang::detail {
namespace {

constexpr double kAlikeSize = 1.4;  // ratio of sizes up to which markers can be confused
// Price of a marker without a place, and of a place that looks like one and is none's: above any
// allowed place's, or all dots of a row that jumps by a column but the last would be its neighbour.
constexpr double kUnfoundCost = 80.0;
constexpr double kClearly = 9.0;       // a likelihood ratio of e^4.5
constexpr double kSurely = 20.0;       // while others may still tell more
constexpr double kMarkersApart = 0.5;  // of two markers' centres, in sizes
constexpr double kPaper = 1.2;         // nearer than that one marker's paper covers the other
constexpr double kNearerThanAtRest = 0.8;
constexpr double kSureCompanion = 0.7;  // sigma up to which companions are asked first, in sizes
constexpr double kBesideCompanionSizes = 0.4;
constexpr int kMostContradicted = 3;    // frames; then the motion has changed its shape
constexpr double kStrangerSigma = 0.1;  // in sizes

const Eigen::Vector2d kNowhere = Eigen::Vector2d::Constant(kNaN);

MarkerSample sample_of(const MarkerAlignment& found) {
  return {found.placement.position_px, found.sigma_px, ""};
}

}  // namespace

LayoutFollower::LayoutFollower(const LumaFrame& first, const Rig& rig, PartialLayout layout)
    : m_rig(rig),
      m_companions(rig.markers.size()),
      m_contradicted(rig.markers.size(), 0),
      m_width_px(first.width_px),
      m_height_px(first.height_px) {
  for (const auto& marker : layout.markers) {
    m_first.push_back(marker ? sample_of(marker->alignment)
                             : MarkerSample{kNowhere, kNaN, "it is hidden or blurred"});
  }
  m_followers = start_followers(rig, std::move(layout));
  m_strangers = find_strangers(first, m_followers, m_first);
}

bool LayoutFollower::alike(std::size_t i, std::size_t k) const {
  const double ratio = m_followers[i].size_px() / m_followers[k].size_px();
  return m_followers[i].pattern() == m_followers[k].pattern() && ratio < kAlikeSize &&
         ratio > 1.0 / kAlikeSize;
}

void LayoutFollower::withdraw(std::size_t marker, std::string why) {
  State& state = m_states[marker];
  if (state.found) state.places.push_back(state.found->px());
  state.found.reset();
  state.why = std::move(why);
}

void LayoutFollower::look_ahead(const LumaFrame& frame) {
  for (std::size_t i = 0; i < m_followers.size(); ++i) {
    if (!m_followers[i].seen()) continue;
    Finding finding = m_followers[i].look_ahead(frame);
    if (finding.good()) {
      m_states[i].found = std::move(finding);
    } else {
      m_states[i].why = finding.why_not;
    }
  }
}

/// Whether two markers that were found could as well stand in each other's places.
bool LayoutFollower::swappable(std::size_t i, std::size_t k) const {
  const Eigen::Vector2d& at_i = m_states[i].found->px();
  const Eigen::Vector2d& at_k = m_states[k].found->px();
  const auto cost = [&](std::size_t marker, const Eigen::Vector2d& px) {
    return m_followers[marker].cost(px, m_states[marker].companion);
  };
  const double swapped = cost(i, at_k) + cost(k, at_i);
  return swapped < cost(i, at_i) + cost(k, at_k) + kClearly;
}

/// Whether a finding can be none but this marker, given what was found of the others.
bool LayoutFollower::clear(std::size_t i, const Finding& finding) const {
  const double size = m_followers[i].size_px();
  const double own = m_followers[i].cost(finding.px(), m_states[i].companion);
  for (std::size_t k = 0; k < m_followers.size(); ++k) {
    if (k == i) continue;
    const std::optional<Finding>& found = m_states[k].found;
    if (found && (found->px() - finding.px()).norm() < kMarkersApart * size) return false;
    if (!alike(i, k)) continue;
    const double other = m_followers[k].cost(finding.px(), m_states[k].companion);
    if (other > own + kClearly) continue;
    // Unless the other one is surely elsewhere.
    if (!found || other < m_followers[k].cost(found->px(), m_states[k].companion) + kClearly) {
      return false;
    }
  }
  return true;
}

/// Findings that another marker could claim as well go back to be decided jointly.
void LayoutFollower::withdraw_doubtful() {
  std::vector<std::size_t> doubtful;
  for (std::size_t i = 0; i < m_followers.size(); ++i) {
    if (!m_states[i].found) continue;
    for (std::size_t k = 0; k < i; ++k) {
      if (!m_states[k].found) continue;
      const double distance = (m_states[i].found->px() - m_states[k].found->px()).norm();
      const bool same = distance < kMarkersApart * m_followers[i].size_px();
      if (same || (alike(i, k) && swappable(i, k))) {
        doubtful.push_back(i);
        doubtful.push_back(k);
      }
    }
  }
  for (const std::size_t i : doubtful) withdraw(i, "several places look like it");
  withdraw_contradicted();
  // What was lost may be what another found, and so on.
  do {
    doubtful.clear();
    for (std::size_t i = 0; i < m_followers.size(); ++i) {
      if (m_states[i].found && !clear(i, *m_states[i].found)) doubtful.push_back(i);
    }
    for (const std::size_t i : doubtful) withdraw(i, "several places look like it");
  } while (!doubtful.empty());
}

/// Findings that contradict what most of the others' motion says.
bool LayoutFollower::withdraw_contradicted() {
  const std::vector<Eigen::Vector2d> known = moved();
  std::vector<std::size_t> contradicted;
  for (std::size_t i = 0; i < m_followers.size(); ++i) {
    if (!m_states[i].found || m_rig.markers[i].fixed) continue;
    const double size = m_followers[i].size_px();
    if (!m_companions.contradict(i, known, kBesideCompanionSizes * size, kSureCompanion * size)) {
      continue;
    }
    m_states[i].contradicted = true;
    if (m_contradicted[i] < kMostContradicted) contradicted.push_back(i);
  }
  for (const std::size_t i : contradicted) withdraw(i, "the others' motion says it is elsewhere");
  return !contradicted.empty();
}

/// The camera's shift from the first picture, by the fixed markers found.
void LayoutFollower::note_camera() {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < m_followers.size(); ++i) {
    if (!m_rig.markers[i].fixed || !m_states[i].found || !m_first[i].position_px.allFinite()) {
      continue;
    }
    sum += m_states[i].found->px() - m_first[i].position_px;
    count += 1.0;
  }
  if (count > 0.0) m_camera_shift = sum / count;
  for (MarkerFollower& follower : m_followers) follower.shift_rest(m_camera_shift);
}

/// How far the moving markers found have gone from rest.
std::vector<Eigen::Vector2d> LayoutFollower::moved() const {
  std::vector<Eigen::Vector2d> moved(m_followers.size(), kNowhere);
  for (std::size_t i = 0; i < m_followers.size(); ++i) {
    if (m_rig.markers[i].fixed || !m_states[i].found) continue;
    moved[i] = m_states[i].found->px() - m_followers[i].rest_px();
  }
  return moved;
}

/// Markers that are not where they were expected, sought where those that moved with them say; the
/// surest first, since it may tell of others.
void LayoutFollower::ask_companions(const LumaFrame& frame) {
  std::vector<bool> asked(m_followers.size(), false);
  while (true) {
    const std::vector<Eigen::Vector2d> known = moved();
    std::size_t best = m_followers.size();
    for (std::size_t i = 0; i < m_followers.size(); ++i) {
      State& state = m_states[i];
      if (state.found || m_rig.markers[i].fixed) continue;
      if (const auto companion = m_companions.predict(i, known)) {
        state.companion = Forecast{m_followers[i].rest_px() + companion->px, companion->sigma_px};
      }
      if (asked[i] || !state.companion ||
          state.companion->sigma_px > kSureCompanion * m_followers[i].size_px()) {
        continue;
      }
      if (best == m_followers.size() ||
          state.companion->sigma_px < m_states[best].companion->sigma_px) {
        best = i;
      }
    }
    if (best == m_followers.size()) return;
    asked[best] = true;
    State& state = m_states[best];
    Finding finding = m_followers[best].look_at(frame, state.companion->px);
    if (!finding.good()) {
      state.why = finding.why_not;
    } else if (std::isfinite(m_followers[best].cost(finding.px(), state.companion)) &&
               clear(best, finding)) {
      state.found = std::move(finding);
    } else {
      state.places.push_back(finding.px());
    }
  }
}

void LayoutFollower::assign_rest(const LumaFrame& frame, double margin) {
  std::vector<bool> done(m_followers.size(), false);
  for (std::size_t i = 0; i < m_followers.size(); ++i) {
    if (m_states[i].found || done[i]) continue;
    std::vector<std::size_t> group;
    for (std::size_t k = i; k < m_followers.size(); ++k) {
      if (m_states[k].found || done[k] || !alike(i, k)) continue;
      group.push_back(k);
      done[k] = true;
    }
    assign_group(frame, group, margin);
  }
}

/// Markers that look alike and every place that could be one of them.
void LayoutFollower::assign_group(const LumaFrame& frame,
                                  const std::vector<std::size_t>& group,
                                  double margin) {
  std::vector<Eigen::Vector2d> places;
  const auto add_place = [&](const Eigen::Vector2d& px, double apart_px) {
    const auto near = [&](const Eigen::Vector2d& other) { return (other - px).norm() < apart_px; };
    if (std::any_of(places.begin(), places.end(), near)) return;
    for (const State& state : m_states) {
      if (state.found && near(state.found->px())) return;
    }
    places.push_back(px);
  };
  for (const std::size_t i : group) {
    State& state = m_states[i];
    const double apart_px = kMarkersApart * m_followers[i].size_px();
    if (!std::exchange(state.searched, true)) {
      const char* why = nullptr;
      for (const Finding& finding : m_followers[i].look_around(frame, state.companion, why)) {
        state.places.push_back(finding.px());
      }
      if (why != nullptr && state.places.empty()) state.why = why;
    }
    for (const Eigen::Vector2d& px : state.places) add_place(px, apart_px);
  }
  if (places.empty()) return;

  const auto num_strangers = m_strangers.size();
  const auto rows = static_cast<Eigen::Index>(group.size() + num_strangers);
  const auto columns = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd cost = Eigen::MatrixXd::Constant(rows, columns, kInfinity);
  std::vector<std::vector<std::optional<Finding>>> findings(group.size());
  for (std::size_t g = 0; g < group.size(); ++g) {
    const MarkerFollower& follower = m_followers[group[g]];
    findings[g].resize(places.size());
    for (std::size_t p = 0; p < places.size(); ++p) {
      if (!std::isfinite(follower.cost(places[p], m_states[group[g]].companion))) continue;
      Finding finding = follower.look_at(frame, places[p]);
      if (!finding.good() ||
          (finding.px() - places[p]).norm() > kMarkersApart * follower.size_px()) {
        continue;
      }
      cost(static_cast<Eigen::Index>(g), static_cast<Eigen::Index>(p)) =
          follower.cost(finding.px(), m_states[group[g]].companion);
      findings[g][p] = std::move(finding);
    }
  }
  for (std::size_t s = 0; s < num_strangers; ++s) {
    const MarkerFollower& like = m_followers[m_strangers[s].like];
    if (!alike(m_strangers[s].like, group.front())) continue;
    for (std::size_t p = 0; p < places.size(); ++p) {
      const double beside =
          (places[p] - m_strangers[s].px - m_camera_shift).norm() / like.size_px();
      if (beside > 3.0 * kStrangerSigma) continue;
      cost(static_cast<Eigen::Index>(group.size() + s), static_cast<Eigen::Index>(p)) =
          std::pow(beside / kStrangerSigma, 2) +
          2.0 * std::log(kTwoPi * kStrangerSigma * kStrangerSigma);
    }
  }
  const Assignment assignment = assign_markers_with_margins(cost, kUnfoundCost);
  for (std::size_t g = 0; g < group.size(); ++g) {
    State& state = m_states[group[g]];
    if (assignment.place[g] < 0) continue;
    if (assignment.margin[g] > margin) {
      state.found = std::move(findings[g][static_cast<std::size_t>(assignment.place[g])]);
    } else {
      state.why = "several places look like it";
      for (std::size_t k = 0; k < group.size(); ++k) {
        if (k == g || !findings[k][static_cast<std::size_t>(assignment.place[g])]) continue;
        state.why = fmt::format("it cannot be told from '{}'", m_rig.markers[group[k]].id);
      }
    }
  }
}

/// A marker whose paper reaches into another's picture moves it: both are in doubt, unless they are
/// as near as that at rest.
void LayoutFollower::withdraw_covered() {
  std::vector<std::pair<std::size_t, std::size_t>> covered;
  for (std::size_t i = 0; i < m_followers.size(); ++i) {
    if (!m_states[i].found) continue;
    for (std::size_t k = 0; k < m_followers.size(); ++k) {
      if (k == i || !m_followers[k].seen()) continue;
      const bool known = m_states[k].found.has_value();
      const double sum = m_followers[i].size_px() + m_followers[k].size_px();
      const double apart = 0.5 * kPaper * sum;
      if (!known && m_followers[k].forecast().sigma_px > 0.5 * kMarkersApart * sum) continue;
      const Eigen::Vector2d& other = known ? m_states[k].found->px() : m_followers[k].forecast().px;
      const double distance = (m_states[i].found->px() - other).norm();
      const double at_rest = (m_followers[i].rest_px() - m_followers[k].rest_px()).norm();
      if (distance < apart && distance < kNearerThanAtRest * at_rest) covered.emplace_back(i, k);
    }
  }
  for (const auto& [i, k] : covered) {
    if (!m_states[i].found) continue;
    m_states[i].found.reset();
    m_states[i].why = fmt::format("'{}' passes over it", m_rig.markers[k].id);
  }
}

std::vector<MarkerSample> LayoutFollower::follow(const LumaFrame& frame) {
  m_states.assign(m_followers.size(), {});
  look_ahead(frame);
  note_camera();
  withdraw_doubtful();
  const auto num_markers = static_cast<std::ptrdiff_t>(m_states.size());
  const auto num_found = [&] {
    return std::count_if(
        m_states.begin(), m_states.end(), [](const State& s) { return s.found.has_value(); });
  };
  // Who is found tells of others.
  for (int pass = 0; pass < 2; ++pass) {
    double margin = kSurely;
    while (num_found() < num_markers) {
      const auto before = num_found();
      ask_companions(frame);
      assign_rest(frame, margin);
      if (num_found() > before) continue;
      if (margin == kClearly) break;
      margin = kClearly;
    }
    if (!withdraw_contradicted()) break;
  }
  withdraw_covered();
  for (std::size_t i = 0; i < m_states.size(); ++i) {
    m_contradicted[i] = m_states[i].contradicted ? m_contradicted[i] + 1 : 0;
  }
  m_companions.add(moved());

  std::vector<MarkerSample> samples;
  for (std::size_t i = 0; i < m_followers.size(); ++i) {
    if (m_states[i].found) {
      samples.push_back(sample_of(m_states[i].found->alignment));
      m_followers[i].accept(frame, std::move(*m_states[i].found));
      continue;
    }
    const Eigen::Vector2d& due = m_followers[i].forecast().px;
    const double rim = 0.5 * m_followers[i].size_px();
    const bool outside =
        due.x() < rim || due.y() < rim || due.x() > m_width_px - rim || due.y() > m_height_px - rim;
    samples.push_back({kNowhere, kNaN, outside ? "it left the picture" : m_states[i].why});
    m_followers[i].lose();
  }
  return samples;
}

}  // namespace twang::detail
