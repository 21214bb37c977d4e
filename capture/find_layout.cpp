// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/find_layout.hpp"

#include "capture/detail/check_layout.hpp"
#include "capture/detail/in_parallel.hpp"
#include "capture/detail/marker_candidates.hpp"
#include "capture/detail/match_constellation.hpp"
#include "capture/detail/place_patches.hpp"
#include "capture/detail/search_marker.hpp"
#include "capture/marker_pattern.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

#include <Eigen/LU>
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
// A stated start is within this part of the picture's longer side of anything that bears on it.
constexpr double kStartNeighbourhood = 0.12;
// A stated start lies on its marker or at most so far beside its centre.
constexpr double kStartSlack = 1.0;     // marker sizes
constexpr double kStartSlack_px = 8.0;  // at least
constexpr double kLeastFinalScore = 0.7;
constexpr double kLeastCorrelation = 0.45;  // of a place worth a closer look
constexpr double kSmallestSought_px = 4.0;
// Against the median of all markers found: motion blur and shading change them by less.
constexpr double kMostScoreDrop = 0.12;
constexpr double kMostSizeMisfit = 0.2;
constexpr double kMostContrastRatio = 2.5;

std::string at_text(const Eigen::Vector2d& px) {
  return fmt::format("({:.0f}, {:.0f})", px.x(), px.y());
}

class LayoutSearch {
 public:
  LayoutSearch(const LumaFrame& frame,
               const Rig& rig,
               const std::map<std::string, Eigen::Vector2d>& start_px,
               const std::string& film,
               const std::string& picture)
      : m_frame(frame),
        m_rig(rig),
        m_starts(start_px),
        m_film(film),
        m_picture(picture),
        m_markers(detail::layout_markers(rig)) {
    for (const MarkerPattern& pattern : patterns()) m_fitters.try_emplace(pattern, frame);
  }

  PartialLayout run();

 private:
  [[nodiscard]] std::vector<MarkerPattern> patterns() const;
  [[nodiscard]] std::vector<Constellation> match();
  bool place_starts();
  int candidate_near(const MarkerPattern& pattern, const Eigen::Vector2d& start);
  void report_missing(std::size_t marker);
  void report_ambiguous(const std::vector<Constellation>& choices);
  void fit(const Constellation& found);
  std::optional<FittedMarker> fit_at(const MarkerPattern& pattern,
                                     const MarkerPlacement& place,
                                     double size_px);
  void look_closer();
  void drop_strangers();
  [[nodiscard]] bool enough() const;
  [[nodiscard]] double due_size_px(std::size_t marker) const;

  const LumaFrame& m_frame;
  const Rig& m_rig;
  const std::map<std::string, Eigen::Vector2d>& m_starts;
  const std::string& m_film;
  const std::string& m_picture;
  std::vector<LayoutMarker> m_markers;
  detail::TemplateStore m_templates;
  std::map<MarkerPattern, MarkerFitter> m_fitters;
  std::vector<MarkerCandidate> m_candidates;
  PartialLayout m_layout;
};

std::vector<MarkerPattern> LayoutSearch::patterns() const {
  std::set<MarkerPattern> patterns;
  for (const LayoutMarker& marker : m_markers) patterns.insert(marker.pattern);
  return {patterns.begin(), patterns.end()};
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

/// Finds the candidates that are meant by the stated places; false if there is none.
bool LayoutSearch::place_starts() {
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
      m_layout.problem =
          fmt::format("{}: marker '{}' was not found near {} in {}, must be {} there",
                      m_film,
                      marker.id,
                      at_text(start->second),
                      m_picture,
                      with_article(to_string(marker.kind)));
      return false;
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (m_markers[k].given != given) continue;
      m_layout.problem =
          fmt::format("{}: markers '{}' and '{}' were both placed at {}, must be two places",
                      m_film,
                      m_rig.markers[k].id,
                      marker.id,
                      at_text(start->second));
      return false;
    }
  }
  return true;
}

void LayoutSearch::report_missing(std::size_t marker) {
  const std::string& id = m_rig.markers[marker].id;
  m_layout.problem = fmt::format(
      "{}: marker '{}' was not found in {}, must be {} of {:g} mm in plain view; "
      "give --marker {}=x,y",
      m_film,
      id,
      m_picture,
      with_article(to_string(m_rig.markers[marker].kind)),
      1e3 * m_rig.markers[marker].size_m,
      id);
}

void LayoutSearch::report_ambiguous(const std::vector<Constellation>& choices) {
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    std::set<int> places;
    for (const Constellation& choice : choices) places.insert(choice.candidate[i]);
    places.erase(-1);
    if (places.size() < 2) continue;
    m_layout.problem = fmt::format(
        "{}: marker '{}' could be one of {} places in {}, must be one; "
        "give --marker {}=x,y",
        m_film,
        m_rig.markers[i].id,
        places.size(),
        m_picture,
        m_rig.markers[i].id);
    return;
  }
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    if (choices.front().candidate[i] < 0) return report_missing(i);
  }
}

/// Outer size of a marker at rest under the layout's map [px].
double LayoutSearch::due_size_px(std::size_t marker) const {
  const LayoutMarker& m = m_markers[marker];
  const double area = map_jacobian(m_layout.px_from_plane, m.rest).determinant();
  return m.size_m * std::sqrt(std::abs(area));
}

/// What stands there, if it is a marker at all.
std::optional<FittedMarker> LayoutSearch::fit_at(const MarkerPattern& pattern,
                                                 const MarkerPlacement& place,
                                                 double size_px) {
  FittedMarker fitted = m_fitters.at(pattern).fit(pattern, place, 0.5 * size_px + 1.0);
  if (!fitted.alignment.converged || fitted.alignment.score < kLeastFinalScore) return std::nullopt;
  return fitted;
}

void LayoutSearch::fit(const Constellation& found) {
  m_layout.px_from_plane = found.px_from_plane;
  m_layout.markers.resize(m_markers.size());
  const std::vector<MarkerPattern> kinds = patterns();
  detail::for_each_in_parallel(kinds.size(), [&](std::size_t kind) {
    for (std::size_t i = 0; i < m_markers.size(); ++i) {
      if (found.candidate[i] < 0 || m_markers[i].pattern != kinds[kind]) continue;
      const auto& candidate = m_candidates[static_cast<std::size_t>(found.candidate[i])];
      m_layout.markers[i] = fit_at(candidate.pattern, candidate.placement, candidate.size_px);
    }
  });
}

/// A marker that no blob showed (it touches something dark) is sought where the others put it.
void LayoutSearch::look_closer() {
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    if (m_layout.markers[i]) continue;
    const LayoutMarker& marker = m_markers[i];
    const double size_px = due_size_px(i);
    if (!(size_px > kSmallestSought_px)) continue;
    const Eigen::Matrix2d jacobian = map_jacobian(m_layout.px_from_plane, marker.rest);
    const double px_per_m = size_px / marker.size_m;
    const double turn =
        -std::atan2(jacobian(1, 0) - jacobian(0, 1), jacobian(0, 0) + jacobian(1, 1));
    const Eigen::Vector2d middle =
        map_point(m_layout.px_from_plane, marker.rest + 0.5 * marker.reach);
    const double reach = px_per_m * (0.5 * marker.reach.norm() + 2.0 * marker.loose) + size_px;
    const MarkerPlacement due = upright_marker(middle, size_px, turn);
    for (const detail::MarkerPeak& peak :
         detail::search_marker(m_frame,
                               m_templates.get(marker.pattern, size_px),
                               due.px_from_pattern,
                               middle,
                               reach,
                               kLeastCorrelation)) {
      const bool taken =
          std::any_of(m_layout.markers.begin(), m_layout.markers.end(), [&](const auto& other) {
            return other && (other->alignment.placement.position_px - peak.position_px).norm() <
                                0.5 * size_px;
          });
      if (taken) continue;
      std::optional<FittedMarker> fitted =
          fit_at(marker.pattern, {peak.position_px, due.px_from_pattern, due.motion_px}, size_px);
      if (fitted && (!m_layout.markers[i] ||
                     fitted->alignment.score > m_layout.markers[i]->alignment.score)) {
        m_layout.markers[i] = std::move(fitted);
      }
    }
  }
}

/// What stands in a marker's place but looks worse than the others do, or has another size or
/// contrast, is something else: the marker is hidden.
void LayoutSearch::drop_strangers() {
  std::vector<double> scores, sizes, contrasts;
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    if (!m_layout.markers[i]) continue;
    const MarkerAlignment& found = m_layout.markers[i]->alignment;
    scores.push_back(found.score);
    sizes.push_back(placed_size_px(found.placement) / due_size_px(i));
    contrasts.push_back(found.contrast);
  }
  const auto median = [](std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  if (scores.size() < 3) return;  // too few to say what is usual
  const double score = median(scores);
  const double size = median(sizes);
  const double contrast = median(contrasts);
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    if (!m_layout.markers[i] || m_markers[i].given >= 0) continue;
    const MarkerAlignment& found = m_layout.markers[i]->alignment;
    const double misfit = placed_size_px(found.placement) / due_size_px(i) / size;
    const double paler = found.contrast / contrast;
    if (found.score < score - kMostScoreDrop || std::abs(std::log(misfit)) > kMostSizeMisfit ||
        paler > kMostContrastRatio || paler < 1.0 / kMostContrastRatio) {
      m_layout.markers[i].reset();
    }
  }
}

/// Half of the markers, and three or all the fixed ones: of fewer any pair would do.
bool LayoutSearch::enough() const {
  int found = 0;
  int found_fixed = 0;
  int fixed = 0;
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    found += m_layout.markers[i] ? 1 : 0;
    fixed += m_markers[i].fixed ? 1 : 0;
    found_fixed += m_layout.markers[i] && m_markers[i].fixed ? 1 : 0;
  }
  const int all = static_cast<int>(m_markers.size());
  return found == all || (2 * found >= all && (found >= 3 || (fixed >= 2 && found_fixed == fixed)));
}

/// The constellations that fit about as well as the best: first among large candidates, and unless
/// these are all markers, among all. None if a stated place has no candidate (`problem` says so).
std::vector<Constellation> LayoutSearch::match() {
  detail::CandidateSearch search(
      m_frame, patterns(), {0, 0, m_frame.width_px, m_frame.height_px}, m_templates);
  const bool all_stated = m_starts.size() == m_rig.markers.size();
  std::vector<Constellation> choices;
  for (const bool small : {false, true}) {
    if (!all_stated) small ? search.look_for_small() : search.look_for_large();
    m_candidates = search.found();
    m_layout.problem.clear();
    m_layout.hopeless = !place_starts();
    choices.clear();
    if (!m_layout.hopeless) {
      choices = detail::match_constellation(m_markers, m_candidates, kMostTurn_rad).about_as_good;
    }
    const bool complete =
        choices.size() == 1 && choices.front().num_matched == static_cast<int>(m_markers.size());
    if (complete || all_stated) break;
  }
  return choices;
}

PartialLayout LayoutSearch::run() {
  m_layout.markers.resize(m_markers.size());
  const std::vector<Constellation> choices = match();
  if (m_layout.hopeless) return std::move(m_layout);
  if (choices.empty()) {
    report_missing(0);
    return std::move(m_layout);
  }
  const Constellation& best = choices.front();
  m_layout.num_found = best.num_matched;
  if (choices.size() > 1) {
    report_ambiguous(choices);
    m_layout.hopeless = best.num_matched == static_cast<int>(m_markers.size());
    return std::move(m_layout);
  }
  fit(best);
  if (enough()) look_closer();
  drop_strangers();
  m_layout.num_found = 0;
  for (std::size_t i = m_markers.size(); i-- > 0;) {
    if (!m_layout.markers[i]) report_missing(i);
    m_layout.num_found += m_layout.markers[i] ? 1 : 0;
  }
  m_layout.usable = enough();
  return std::move(m_layout);
}

}  // namespace

Eigen::Vector2d plane_position(const Camera& camera, const Eigen::Vector3d& position) {
  return {camera.image_right.dot(position), camera.image_down.dot(position)};
}

PartialLayout search_layout(const LumaFrame& frame,
                            const Rig& rig,
                            const std::map<std::string, Eigen::Vector2d>& start_px,
                            const std::string& film,
                            const std::string& picture) {
  detail::check_markers(rig);
  detail::check_starts(frame, rig, start_px);
  const Rig printed = detail::without_patches(rig);
  if (printed.markers.size() == rig.markers.size()) {
    return LayoutSearch(frame, rig, start_px, film, picture).run();
  }
  std::map<std::string, Eigen::Vector2d> starts = start_px;
  std::erase_if(starts, [&](const auto& start) { return !printed.find_marker(start.first); });
  return detail::place_patches({frame, rig, start_px, film, picture},
                               printed.markers.empty()
                                   ? PartialLayout{}
                                   : LayoutSearch(frame, printed, starts, film, picture).run());
}

Layout find_layout(const LumaFrame& frame,
                   const Rig& rig,
                   const std::map<std::string, Eigen::Vector2d>& start_px,
                   const std::string& film) {
  PartialLayout found = search_layout(frame, rig, start_px, film, "the first frame");
  if (!found.problem.empty()) throw InputError(found.problem);
  Layout layout;
  layout.px_from_plane = found.px_from_plane;
  for (auto& marker : found.markers) layout.markers.push_back(std::move(*marker));
  return layout;
}

}  // namespace twang
