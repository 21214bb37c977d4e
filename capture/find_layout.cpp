// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/find_layout.hpp"

#include "capture/detail/marker_candidates.hpp"
#include "capture/detail/match_constellation.hpp"
#include "capture/marker_pattern.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

namespace twang {
namespace {

using detail::Constellation;
using detail::LayoutMarker;
using detail::MarkerCandidate;

constexpr double kMostTurn_rad = 30.0 * kRadiansPerDegree;
// One sigma of where a moving marker may stand: half the release, any direction, or without one
// this part of the layout's extent.
constexpr double kLooseOfRelease = 0.5;
constexpr double kLooseOfExtent = 0.075;
// A stated start is within this part of the picture's longer side of anything that bears on it.
constexpr double kStartNeighbourhood = 0.12;
// A stated start lies on its marker or at most so far beside its centre.
constexpr double kStartSlack = 1.0;     // marker sizes
constexpr double kStartSlack_px = 8.0;  // at least
constexpr double kLeastFinalScore = 0.7;

std::string at_text(const Eigen::Vector2d& px) {
  return fmt::format("({:.0f}, {:.0f})", px.x(), px.y());
}

void check_kinds(const Rig& rig) {
  for (const Marker& marker : rig.markers) {
    try {
      static_cast<void>(MarkerPattern(marker));
    } catch (const InputError&) {
      throw InputError(
          fmt::format("{}: marker '{}' is of kind '{}', which cannot be tracked, must be cross, "
                      "dot, ring or checker",
                      rig.file.empty() ? "rig '" + rig.name + "'" : rig.file.string(),
                      marker.id,
                      to_string(marker.kind)));
    }
  }
}

void check_starts(const LumaFrame& frame,
                  const Rig& rig,
                  const std::map<std::string, Eigen::Vector2d>& start_px) {
  for (const auto& [id, px] : start_px) {
    if (!rig.find_marker(id)) {
      std::vector<std::string> ids;
      for (const Marker& marker : rig.markers) ids.push_back(marker.id);
      throw InputError(fmt::format(
          "--marker {}: the rig has no such marker, must be one of its ids (nearest: '{}')",
          id,
          nearest_word(id, ids)));
    }
    const bool inside = px.x() >= 0.0 && px.y() >= 0.0 && px.x() <= frame.width_px - 1 &&
                        px.y() <= frame.height_px - 1;
    if (!inside) {
      throw InputError(
          fmt::format("--marker {}={},{}: lies outside the picture, must be within "
                      "{} x {} pixels",
                      id,
                      px.x(),
                      px.y(),
                      frame.width_px,
                      frame.height_px));
    }
  }
}

class LayoutSearch {
 public:
  LayoutSearch(const LumaFrame& frame,
               const Rig& rig,
               const std::map<std::string, Eigen::Vector2d>& start_px,
               const std::string& film)
      : m_frame(frame), m_rig(rig), m_starts(start_px), m_film(film) {}

  Layout run();

 private:
  [[nodiscard]] std::vector<MarkerPattern> patterns() const;
  void describe_markers();
  void gather_candidates();
  int candidate_near(const MarkerPattern& pattern, const Eigen::Vector2d& start);
  Constellation match();
  void look_closer(Constellation& found);
  [[noreturn]] void refuse_missing(std::size_t marker) const;
  void refuse_ambiguous(const std::vector<Constellation>& choices) const;
  Layout fit(const Constellation& found);

  const LumaFrame& m_frame;
  const Rig& m_rig;
  const std::map<std::string, Eigen::Vector2d>& m_starts;
  const std::string& m_film;
  detail::TemplateStore m_templates;
  std::vector<LayoutMarker> m_markers;
  std::vector<MarkerCandidate> m_candidates;
};

std::vector<MarkerPattern> LayoutSearch::patterns() const {
  std::set<MarkerPattern> patterns;
  for (const LayoutMarker& marker : m_markers) patterns.insert(marker.pattern);
  return {patterns.begin(), patterns.end()};
}

void LayoutSearch::describe_markers() {
  const Camera& camera = *m_rig.camera;
  double extent = 0.0;
  for (const Marker& a : m_rig.markers) {
    for (const Marker& b : m_rig.markers) {
      extent = std::max(
          extent, (plane_position(camera, a.position) - plane_position(camera, b.position)).norm());
    }
  }
  for (const Marker& marker : m_rig.markers) {
    LayoutMarker described{MarkerPattern(marker)};
    described.rest = plane_position(camera, marker.position);
    described.size_m = marker.size_m;
    described.fixed = marker.fixed;
    if (!marker.fixed && m_rig.release && m_rig.release->displacement) {
      described.reach = plane_position(camera, *m_rig.release->displacement);
      described.loose = kLooseOfRelease * described.reach.norm();
    } else if (!marker.fixed) {
      described.loose = kLooseOfExtent * extent;
    }
    m_markers.push_back(described);
  }
}

/// The candidate that a stated start means: the nearest of its kind whose marker covers the place,
/// or about so.
int LayoutSearch::candidate_near(const MarkerPattern& pattern, const Eigen::Vector2d& start) {
  int nearest = -1;
  double least = kInfinity;
  for (std::size_t c = 0; c < m_candidates.size(); ++c) {
    const MarkerCandidate& candidate = m_candidates[c];
    const double distance = (candidate.placement.position_px - start).norm();
    const double slack = std::max(kStartSlack * candidate.size_px, kStartSlack_px);
    if (candidate.pattern != pattern || distance > slack || distance >= least) continue;
    least = distance;
    nearest = static_cast<int>(c);
  }
  return nearest;
}

/// In the whole picture, or around the stated starts if all are stated.
void LayoutSearch::gather_candidates() {
  if (m_starts.size() < m_rig.markers.size()) {
    m_candidates = detail::find_candidates(
        m_frame, patterns(), {0, 0, m_frame.width_px, m_frame.height_px}, m_templates);
  }
  const int reach =
      static_cast<int>(kStartNeighbourhood * std::max(m_frame.width_px, m_frame.height_px));
  for (std::size_t i = 0; i < m_rig.markers.size(); ++i) {
    const Marker& marker = m_rig.markers[i];
    const auto start = m_starts.find(marker.id);
    if (start == m_starts.end()) continue;
    int& given = m_markers[i].given;
    given = candidate_near(m_markers[i].pattern, start->second);
    if (given < 0) {
      const int x = static_cast<int>(start->second.x());
      const int y = static_cast<int>(start->second.y());
      const detail::SearchBox around{std::max(0, x - reach),
                                     std::max(0, y - reach),
                                     std::min(m_frame.width_px, x + reach),
                                     std::min(m_frame.height_px, y + reach)};
      const auto near =
          detail::find_candidates(m_frame, {m_markers[i].pattern}, around, m_templates);
      m_candidates.insert(m_candidates.end(), near.begin(), near.end());
      given = candidate_near(m_markers[i].pattern, start->second);
    }
    if (given < 0) {
      throw InputError(
          fmt::format("{}: marker '{}' was not found near {} in the first frame, must "
                      "be a {} there",
                      m_film,
                      marker.id,
                      at_text(start->second),
                      to_string(marker.kind)));
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (m_markers[k].given != given) continue;
      throw InputError(
          fmt::format("{}: markers '{}' and '{}' were both placed at {}, must be two "
                      "places",
                      m_film,
                      m_rig.markers[k].id,
                      marker.id,
                      at_text(start->second)));
    }
  }
}

void LayoutSearch::refuse_missing(std::size_t marker) const {
  const std::string& id = m_rig.markers[marker].id;
  throw InputError(
      fmt::format("{}: marker '{}' was not found in the first frame, must be a {} of "
                  "{:g} mm in plain view; give --marker {}=x,y",
                  m_film,
                  id,
                  to_string(m_rig.markers[marker].kind),
                  1e3 * m_rig.markers[marker].size_m,
                  id));
}

void LayoutSearch::refuse_ambiguous(const std::vector<Constellation>& choices) const {
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    std::set<int> places;
    for (const Constellation& choice : choices) places.insert(choice.candidate[i]);
    places.erase(-1);
    if (places.size() < 2) continue;
    throw InputError(
        fmt::format("{}: marker '{}' could be one of {} places in the first frame, "
                    "must be one; give --marker {}=x,y",
                    m_film,
                    m_rig.markers[i].id,
                    places.size(),
                    m_rig.markers[i].id));
  }
}

/// A marker that no blob showed (it touches something dark) is sought where the others put it.
void LayoutSearch::look_closer(Constellation& found) {
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    if (found.candidate[i] >= 0) continue;
    const LayoutMarker& marker = m_markers[i];
    const double px_per_m = std::abs(found.px_from_plane.scale);
    const double size_px = marker.size_m * px_per_m;
    const Eigen::Vector2d middle = found.px_from_plane.apply(marker.rest + 0.5 * marker.reach);
    const double reach = px_per_m * (0.5 * marker.reach.norm() + 2.0 * marker.loose) + size_px;
    const double step = 0.25 * size_px;
    const double turn = -std::arg(found.px_from_plane.scale);
    std::optional<MarkerCandidate> best;
    for (double dy = -reach; dy <= reach; dy += step) {
      for (double dx = -reach; dx <= reach; dx += step) {
        AlignOptions options;
        options.farthest_px = size_px;
        const MarkerAlignment tried =
            align_marker(m_frame,
                         m_templates.get(marker.pattern, size_px),
                         upright_marker(middle + Eigen::Vector2d(dx, dy), size_px, turn),
                         options);
        if (!tried.converged || (best && tried.score <= best->score)) continue;
        best = {marker.pattern, tried.placement, size_px, tried.score};
      }
    }
    if (!best || best->score < kLeastFinalScore) refuse_missing(i);
    for (const int other : found.candidate) {
      if (other < 0) continue;
      const auto& taken = m_candidates[static_cast<std::size_t>(other)];
      const Eigen::Vector2d apart = taken.placement.position_px - best->placement.position_px;
      if (apart.norm() < 0.5 * size_px) refuse_missing(i);
    }
    found.candidate[i] = static_cast<int>(m_candidates.size());
    m_candidates.push_back(*best);
  }
}

Constellation LayoutSearch::match() {
  const auto choices =
      detail::match_constellation(m_markers, m_candidates, kMostTurn_rad).about_as_good;
  if (choices.empty()) refuse_missing(0);
  Constellation found = choices.front();
  const int num_markers = static_cast<int>(m_markers.size());
  if (2 * found.num_matched < num_markers || (num_markers > 1 && found.num_matched < 2)) {
    refuse_missing(static_cast<std::size_t>(
        std::find(found.candidate.begin(), found.candidate.end(), -1) - found.candidate.begin()));
  }
  if (choices.size() > 1) refuse_ambiguous(choices);
  look_closer(found);
  return found;
}

Layout LayoutSearch::fit(const Constellation& found) {
  Layout layout;
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    const auto& candidate = m_candidates[static_cast<std::size_t>(found.candidate[i])];
    FittedMarker fitted =
        fit_marker(m_frame, candidate.pattern, candidate.placement, 0.5 * candidate.size_px + 1.0);
    if (!fitted.alignment.converged || fitted.alignment.score < kLeastFinalScore) refuse_missing(i);
    layout.markers.push_back(std::move(fitted));
  }
  const auto& map = found.px_from_plane;
  layout.px_from_plane << map.scale.real(), -map.scale.imag(), map.shift.real(), map.scale.imag(),
      map.scale.real(), map.shift.imag();
  return layout;
}

Layout LayoutSearch::run() {
  describe_markers();
  gather_candidates();
  return fit(match());
}

}  // namespace

Eigen::Vector2d plane_position(const Camera& camera, const Eigen::Vector3d& position) {
  return {camera.image_right.dot(position), camera.image_down.dot(position)};
}

Layout find_layout(const LumaFrame& frame,
                   const Rig& rig,
                   const std::map<std::string, Eigen::Vector2d>& start_px,
                   const std::string& film) {
  if (rig.markers.empty() || !rig.camera) {
    throw InputError(fmt::format("{}: has no {}, must have [[marker]] and [camera] to be tracked",
                                 rig.file.empty() ? "rig '" + rig.name + "'" : rig.file.string(),
                                 rig.markers.empty() ? "[[marker]]" : "[camera]"));
  }
  check_kinds(rig);
  check_starts(frame, rig, start_px);
  return LayoutSearch(frame, rig, start_px, film).run();
}

}  // namespace twang
